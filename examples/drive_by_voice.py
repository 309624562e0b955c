"""Drive a robot by the microphone, until Ctrl-C: python examples/drive_by_voice.py."""

import contextlib

import voz


class Wheels(voz.Robot):
    """Takes the place of a robot: prints what its motors would do."""

    def __init__(self) -> None:
        self.velocities = 0.0, 0.0

    def move(self, linear: float, angular: float) -> None:
        """Hold a velocity, m/s and rad/s; called 10 times a second."""
        if self.velocities != (linear, angular):
            self.velocities = linear, angular
            print(f"{linear:g} m/s, {angular:g} rad/s", flush=True)


safety = voz.Safety(max_linear=0.2)
commands = {"go back": {"drive": -0.05}}  # beside what voz's own commands do
with (
    contextlib.suppress(KeyboardInterrupt),
    voz.Controller(Wheels(), safety=safety, commands=commands, listening=True) as controller,
):
    controller.run(voz.load().microphone())
