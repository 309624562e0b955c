"""Start voz by the options of the add-on, and say to Home Assistant where it is: start.py."""

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

DATA = Path(os.environ.get("VOZ_DATA", "/data"))
"""Where the Supervisor writes the options."""

PORT = int(os.environ.get("VOZ_PORT", "10300"))

SUPERVISOR = os.environ.get("VOZ_SUPERVISOR", "http://supervisor")

PATIENCE = 60.0
"""For voz to answer, s; it takes a second or two, on a small computer more."""


def ask_supervisor(path: str, found: dict[str, Any] | None = None) -> Any:
    """Send the Supervisor something, or ask it; returns its answer, raises OSError."""
    headers = {
        "Authorization": f"Bearer {os.environ.get('SUPERVISOR_TOKEN', '')}",
        "Content-Type": "application/json",
    }
    data = None if found is None else json.dumps(found).encode()
    with urlopen(Request(f"{SUPERVISOR}{path}", data, headers), timeout=10) as answer:
        return json.loads(answer.read() or "null")


def read_options() -> dict[str, Any]:
    """Read the options; their file may be root's alone, and this is not root: then ask for them."""
    try:
        found: dict[str, Any] = json.loads((DATA / "options.json").read_text(encoding="utf-8"))
    except OSError:
        found = ask_supervisor("/addons/self/options/config")["data"]
    return found


def arguments() -> list[str]:
    """Return the command that starts voz; builds the language files of a list."""
    options = read_options()
    alarms = str(options["false_alarms_per_hour"])
    # Not announced by zeroconf: in a container that would name an address nobody reaches.
    started = ["voz", "serve", "--wyoming", f"tcp://0.0.0.0:{PORT}", "--no-zeroconf"]
    started += ["--false-alarms-per-hour", alarms]
    if options["commands"]:
        folder = Path(tempfile.mkdtemp(prefix="voz-"))
        commands, files = folder / "commands.txt", folder / "lm"
        commands.write_text("\n".join(options["commands"]) + "\n", encoding="utf-8")
        built = subprocess.run(["voz", "build-lm", str(commands), "--out", str(files)])
        if built.returncode:
            sys.exit(built.returncode)
        started += ["--lm", str(files)]
    return started


def announce() -> None:
    """Wait until voz answers, and send the Supervisor its address."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        try:
            socket.create_connection(("127.0.0.1", PORT)).close()
            break
        except OSError:
            time.sleep(0.2)
    else:
        return  # it has ended, and said why
    host = socket.gethostname()
    found = {"service": "wyoming", "config": {"uri": f"tcp://{host}:{PORT}"}}
    try:
        ask_supervisor("/discovery", found)
    except (OSError, ValueError) as error:
        print(f"add the integration Wyoming Protocol by hand: host {host}, port {PORT} ({error})")


if __name__ == "__main__":
    command = arguments()
    if os.fork() == 0:
        announce()
    else:
        os.execvp(command[0], command)
