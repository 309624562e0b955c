"""The add-on of `examples/home_assistant`, as far as it runs without Home Assistant."""

from __future__ import annotations

import asyncio
import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any

import pytest
import yaml
from programs import PATIENCE, free_port
from recordings import ROOT
from wyoming.client import AsyncClient
from wyoming.info import Describe, Info

ADD_ON = ROOT / "examples" / "home_assistant" / "voz"
CONFIG: dict[str, Any] = yaml.safe_load((ADD_ON / "config.yaml").read_text())

# As `supervisor/addons/validate.py` of home-assistant/supervisor has them.
ELEMENT = re.compile(r"(bool|email|url|port|str|password|int|float|match|list)(\(.*\))?\??")


def test_each_option_has_a_default_of_its_type() -> None:
    assert set(CONFIG["options"]) == set(CONFIG["schema"])
    for name, kind in CONFIG["schema"].items():
        default = CONFIG["options"][name]
        assert isinstance(default, list) == isinstance(kind, list)
        element = ELEMENT.fullmatch(kind[0] if isinstance(kind, list) else kind)
        assert element
        if element[1] == "float":
            low, high = map(float, element[2].strip("()").split(","))
            assert low <= default <= high
    documented = (ADD_ON / "DOCS.md").read_text()
    assert all(f"| `{name}` |" in documented for name in CONFIG["options"])


def test_its_version_is_that_of_voz_and_the_image_installs_what_it_needs() -> None:
    project = (ROOT / "pyproject.toml").read_text()
    assert f'version = "{CONFIG["version"]}"' in project
    dockerfile = (ADD_ON / "Dockerfile").read_text()
    copied = re.findall(r"^COPY (\S+) ", dockerfile, re.M)
    assert copied == ["voz_robot-*.whl", "start.py"]
    assert "[wyoming]" in dockerfile


def test_its_image_does_not_run_as_root() -> None:
    lines = (ADD_ON / "Dockerfile").read_text().splitlines()
    assert next(line for line in lines if line.startswith(("USER", "CMD"))) == "USER voz"


class Supervisor(HTTPServer):
    """Takes what an add-on sends, as Home Assistant's Supervisor would."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), SupervisorRequest)
        self.requests: Queue[tuple[str, str | None, Any]] = Queue()


class SupervisorRequest(BaseHTTPRequestHandler):
    server: Supervisor

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.requests.put((self.path, self.headers["Authorization"], body))
        self.send_response(200)
        self.end_headers()

    def do_GET(self) -> None:
        assert self.headers["Authorization"] == "Bearer secret"
        self.send_response(200 if self.path == "/addons/self/options/config" else 404)
        self.end_headers()
        answer = {"result": "ok", "data": {**CONFIG["options"], "commands": ["an {asked} one"]}}
        self.wfile.write(json.dumps(answer).encode())

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def supervisor() -> Iterator[Supervisor]:
    with Supervisor() as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


async def describe(uri: str) -> Info:
    async with AsyncClient.from_uri(uri) as client:
        await client.write_event(Describe().event())
        answer = await asyncio.wait_for(client.read_event(), PATIENCE)
    assert answer
    return Info.from_event(answer)


@pytest.mark.slow
@pytest.mark.parametrize("commands", [[], ["turn the {place} light on", "place = kitchen | hall"]])
def test_it_starts_and_says_where_it_is(
    commands: list[str], supervisor: Supervisor, tmp_path: Path
) -> None:
    (tmp_path / "options.json").write_text(json.dumps({**CONFIG["options"], "commands": commands}))
    port = free_port()
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "VOZ_DATA": str(tmp_path),
        "VOZ_PORT": str(port),
        "VOZ_SUPERVISOR": f"http://127.0.0.1:{supervisor.server_port}",
        "SUPERVISOR_TOKEN": "secret",
    }
    command = [sys.executable, str(ADD_ON / "start.py")]
    with subprocess.Popen(
        command, env=environment, cwd=tmp_path, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            path, token, found = supervisor.requests.get(timeout=PATIENCE)
            info = asyncio.run(describe(f"tcp://127.0.0.1:{port}"))
        finally:
            process.terminate()
        assert process.wait(PATIENCE) in (-15, 143)
    assert (path, token) == ("/discovery", "Bearer secret")
    uri = f"tcp://{socket.gethostname()}:{port}"
    assert found == {"service": "wyoming", "config": {"uri": uri}}
    said = info.asr[0].models[0].description or ""
    assert ("turn the kitchen light on" in said) == bool(commands)


@pytest.mark.slow
def test_a_list_that_cannot_be_ends_it_in_one_line(tmp_path: Path) -> None:
    options = {**CONFIG["options"], "commands": ["turn the {place} light on"]}
    (tmp_path / "options.json").write_text(json.dumps(options))
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "VOZ_DATA": str(tmp_path),
    }
    command = [sys.executable, str(ADD_ON / "start.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 2
    assert 'there is no list "place"' in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_options_that_cannot_be_read_are_asked_for(supervisor: Supervisor, tmp_path: Path) -> None:
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "VOZ_DATA": str(tmp_path),
        "VOZ_SUPERVISOR": f"http://127.0.0.1:{supervisor.server_port}",
        "SUPERVISOR_TOKEN": "secret",
    }
    command = [sys.executable, str(ADD_ON / "start.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 2
    assert 'there is no list "asked"' in done.stderr
    assert list(tmp_path.iterdir()) == []
