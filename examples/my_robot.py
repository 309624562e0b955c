"""A robot of one's own: PYTHONPATH=examples voz run --robot my_robot:Lamp --text -."""

from collections.abc import Mapping

from voz import Robot


class Lamp(Robot):
    """A lamp that is on while the robot would move, and tells which commands it obeyed."""

    def open(self) -> None:
        """Get ready; a RobotError that is raised here ends the run with one line."""
        self.on = False

    def move(self, linear: float, angular: float) -> None:
        """Hold a velocity, m/s and rad/s; called 10 times a second."""
        if self.on != bool(linear or angular):
            self.on = not self.on
            print("lamp on" if self.on else "lamp off", flush=True)

    def command(self, name: str, slots: Mapping[str, str | float]) -> None:
        """Do a command that is obeyed."""
        print("obeyed:", name, flush=True)
