"""A robot of one's own: PYTHONPATH=examples voz run --robot my_robot:Lamp --text -."""

from voz import Event, Robot, Twist, Utterance


class Lamp(Robot):
    """A lamp that is on while the robot would move, and tells which commands it obeyed."""

    def open(self) -> None:
        """Get ready; a RobotError that is raised here ends the run with one line."""
        self.on = False

    def receive(self, event: Event) -> None:
        """Take one event; a Twist comes 10 times a second."""
        if isinstance(event, Utterance) and event.obeyed:
            print("obeyed:", event.text, flush=True)
        elif isinstance(event, Twist) and self.on != bool(event.linear or event.angular):
            self.on = not self.on
            print("lamp on" if self.on else "lamp off", flush=True)
