"""A robot on a TCP socket: PYTHONPATH=examples voz run --robot tcp_robot:TcpRobot.

It gets lines `v 0.10 0.00`, m/s and rad/s, 10 times a second, and `c wave`; it must stop by itself
when none comes for half a second. Its address stands in voz.toml:

    [own.tcp_robot]
    host = "192.168.4.1"
    port = 9000
"""

from __future__ import annotations

import socket
from collections.abc import Mapping

from voz import Robot, RobotError

TIMEOUT = 0.3
"""For the robot to answer, or to take a line, s; voz stops all robots after 0.35 s."""


class TcpRobot(Robot):
    """Hands velocities and commands on."""

    def __init__(self, host: str = "192.168.4.1", port: int = 9000) -> None:
        """Take the address."""
        self.address = (host, port)

    def open(self) -> None:
        """Connect."""
        try:
            self.socket = socket.create_connection(self.address, TIMEOUT)
        except OSError as error:
            where = "{}:{}".format(*self.address)
            raise RobotError(f"no robot at {where} ({error}): switch it on") from error
        # Else a zero could wait until the robot has acknowledged the line before it.
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def move(self, linear: float, angular: float) -> None:
        """Send a velocity."""
        self.socket.sendall(f"v {linear:.2f} {angular:.2f}\n".encode())

    def command(self, name: str, slots: Mapping[str, str | float]) -> None:
        """Send a command."""
        self.socket.sendall(f"c {name}\n".encode())

    def close(self) -> None:
        """Hang up."""
        self.socket.close()
