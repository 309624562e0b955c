"""What is asked of a master that is none."""

from __future__ import annotations

import threading
import xmlrpc.client
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from voz.ros1.master import ask, other_senders


class _Answers(BaseHTTPRequestHandler):
    body = b""

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200)
        self.send_header("Content-Length", str(len(self.body)))
        self.end_headers()
        self.wfile.write(self.body)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    with HTTPServer(("127.0.0.1", 0), _Answers) as server:
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{server.server_port}")
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield
        server.shutdown()
        thread.join()


@pytest.mark.usefixtures("server")
def test_a_state_that_is_none_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    body = xmlrpc.client.dumps(((1, "", 7),), methodresponse=True).encode()
    monkeypatch.setattr(_Answers, "body", body)
    assert ask("getPid", "/voz") == 7
    with pytest.raises(OSError, match="is not a ROS master"):
        other_senders("/cmd_vel", "/voz")


@pytest.mark.usefixtures("server")
@pytest.mark.parametrize("body", [b"", b"<html>", b"\xff\x01", b"<methodResponse>&#1;", b"404"])
def test_whatever_is_no_answer_of_a_master_is_none(
    body: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_Answers, "body", body)
    for question in (lambda: ask("getPid", "/voz"), lambda: other_senders("/cmd_vel", "/voz")):
        with pytest.raises(OSError, match="is not a ROS master"):
            question()
