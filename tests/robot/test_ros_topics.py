from __future__ import annotations

from voz.events import Notice
from voz.robot.ros_topics import ONE_SENDER, OtherSenders


def test_each_is_told_of_once_when_it_comes_and_once_when_it_goes() -> None:
    told: list[Notice] = []
    senders = OtherSenders("/cmd_vel", told.append)
    for t, names in enumerate([(), ("/b", "/a"), ("/a", "/b"), ("/b",), ("/b", "/a")]):
        senders.update(float(t), frozenset(names))
    too = f"sends velocities on /cmd_vel too: {ONE_SENDER}"
    assert told == [
        Notice(1.0, f"/a {too}"),
        Notice(1.0, f"/b {too}"),
        Notice(3.0, "/a left /cmd_vel", good=True),
        Notice(4.0, f"/a {too}"),
    ]
