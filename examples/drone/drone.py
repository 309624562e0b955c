"""A drone with numbers; voz.toml beside it says how it is called."""

from __future__ import annotations

from collections.abc import Mapping

from voz import Robot


class Drone(Robot):
    """Prints what it would tell the flight controller."""

    height = 0.0
    velocity = (0.0, 0.0)

    def move(self, linear: float, angular: float) -> None:
        """Hold a velocity; on the ground none does anything."""
        velocity = (linear, angular) if self.height else (0.0, 0.0)
        if velocity != self.velocity:
            self.velocity = velocity
            print(f"fly at {linear:g} m/s, turn at {angular:g} rad/s", flush=True)

    def command(self, name: str, slots: Mapping[str, str | float]) -> None:
        """Do what is no velocity."""
        if name == "take off":
            self.height = 1.0
        elif name == "land":
            self.height = 0.0
        elif name == "climb" and self.height:
            self.height += float(slots["way"])
        else:
            return
        print(f"height {self.height:g} m", flush=True)
