"""An arm that brings things; voz.toml beside it says how it is called."""

from __future__ import annotations

import time
from collections.abc import Mapping

from voz import Event, Publish, Robot

PLACES = {"cup": (0.3, 0.1), "key": (0.2, -0.2), "knife": (0.4, 0.0), "water": (0.1, 0.3)}


class Arm(Robot):
    """Prints what it would do; each thing takes a moment, in which a stop still comes through."""

    slow = True  # `receive` may take its time for all but velocities

    def receive(self, event: Event) -> None:
        """Take what the gripper is told beside the commands."""
        if isinstance(event, Publish) and event.topic == "gripper":
            print("gripper", "open" if event.value else "closed", flush=True)
        super().receive(event)

    def command(self, name: str, slots: Mapping[str, str | float]) -> None:
        """Do a command that is obeyed."""
        if name == "bring":
            thing = str(slots["thing"])
            print("reach", slots.get("color", "any"), thing, "at", PLACES[thing], flush=True)
            time.sleep(0.1)
        elif name == "put":
            print("put the", slots["thing"], "on the", slots["place"], flush=True)
