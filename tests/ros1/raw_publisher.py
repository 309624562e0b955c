"""A publisher that sends any bytes as messages, without rospy, which would refuse to.

Its arguments are a topic, its type and the MD5 of that; each line of its standard input is the
bytes of a message. It begins when it is subscribed to.
"""

from __future__ import annotations

import os
import socket
import struct
import sys
import threading
import xmlrpc.client
from typing import Any
from xmlrpc.server import SimpleXMLRPCServer


def framed(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


topic, kind, md5 = sys.argv[1:]
header = {"callerid": "/raw", "topic": topic, "type": kind, "md5sum": md5}
sender = socket.create_server(("127.0.0.1", 0))
node = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)


def answer(method: str, _: Any) -> Any:
    port = sender.getsockname()[1]
    return (1, "", ["TCPROS", "127.0.0.1", port] if method == "requestTopic" else 0)


node._dispatch = answer  # type: ignore[assignment]
threading.Thread(target=node.serve_forever, daemon=True).start()
with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as master:
    address = f"http://127.0.0.1:{node.server_address[1]}"
    master.registerPublisher("/raw", topic, kind, address)
connection, _ = sender.accept()
connection.recv(10_000)
connection.sendall(framed(b"".join(framed(f"{k}={v}".encode()) for k, v in header.items())))
print("subscribed", flush=True)
for line in sys.stdin:
    connection.sendall(framed(bytes.fromhex(line)))
