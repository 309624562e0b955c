"""From what was heard to what the robot is asked to do: obeys, and tells all who receive events."""

from __future__ import annotations

from collections.abc import Sequence

from voz.config import Safety
from voz.control.controller import State, halt
from voz.control.safety import motion_has_expired, obey_safely
from voz.events import Event, Partial, Receiver, Reply, SelectedObject, Twist, Utterance, Warning

CYCLES_PER_SECOND = 10
"""How often `cmd_vel` goes out, also while nothing is said."""

SWITCH = 0.001
"""How long a thread waits for another to let go of Python, s; 5 ms as usual is seen in the beat."""


class Drive:
    """The robot's state, and who is told of it; time comes in with each call."""

    def __init__(
        self,
        receivers: Sequence[Receiver],
        safety: Safety,
        listening: bool = False,
    ) -> None:
        """Start with the robot at rest.

        Args:
            receivers: called with every event, in order.
            safety: the safety rules' settings.
            listening: whether commands are obeyed before a `start speech`.
        """
        self._receivers = receivers
        self._safety = safety
        self._state = State(listening=listening)
        self._last_command = 0.0

    @property
    def velocities(self) -> tuple[float, float]:
        """What the robot is asked to hold now, m/s and rad/s."""
        return self._state.velocities()

    @property
    def listening(self) -> bool:
        """Whether commands are obeyed."""
        return self._state.listening

    def hear(self, event: Utterance | Partial) -> None:
        """Obey an utterance if it is accepted; halt at what may be a command that stops."""
        self.emit(event)
        if isinstance(event, Partial):
            # A needless halt is better than a late one, and what else it was is settled later.
            outcome = obey_safely(self._state, event.text, self._safety)
            if not outcome.state.moving:
                self._state = halt(self._state)
        elif event.accepted:
            self._obey(event)

    def halt(self) -> None:
        """Ask the robot to stand still from now on."""
        self._state = halt(self._state)

    def send(self, now: float) -> None:
        """Send the velocities once.

        Args:
            now: the time of the run, s.
        """
        if motion_has_expired(self._state, now - self._last_command, self._safety):
            self.halt()
            limit = self._safety.motion_time_limit
            self.emit(Warning(now, f"no command for {limit:g} s: the robot stops"))
        self.emit(Twist(now, *self.velocities))

    def zero(self, now: float) -> None:
        """Send zero velocity once."""
        self.emit(Twist(now, 0.0, 0.0))

    def emit(self, event: Event) -> None:
        """Hand an event to all receivers."""
        for receive in self._receivers:
            receive(event)

    def _obey(self, utterance: Utterance) -> None:
        self._last_command = utterance.t
        self._state, selected, reply = obey_safely(self._state, utterance.text, self._safety)
        if selected is not None:
            self.emit(SelectedObject(utterance.t, selected))
        if reply is not None:
            self.emit(Reply(utterance.t, reply))
