"""From what was heard to what the robot is asked to do: obeys, and tells all who receive events."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from voz.config import Safety
from voz.control.controller import Outcome, State, halt
from voz.control.safety import STOP, motion_has_expired, obey_safely
from voz.events import (
    Event,
    Ignored,
    Partial,
    Receiver,
    Reply,
    SelectedObject,
    Twist,
    Utterance,
    Warning,
)


class Controller:
    """The robot's state, and who is told of it; time comes in with each call.

    Attributes:
        stopped_at: when the motion was last ended by a loss, s. What was said before does not
            begin another.
        rehearsing: whether commands are understood and told, but none but `stop` is obeyed.
    """

    def __init__(
        self,
        receivers: Sequence[Receiver],
        safety: Safety,
        listening: bool = False,
    ) -> None:
        """Start with the robot at rest.

        Args:
            receivers: called with every event, in order; none of them may wait for anything.
            safety: the safety rules' settings.
            listening: whether commands are obeyed before a `start speech`.
        """
        self._receivers = receivers
        self._safety = safety
        self._state = State(listening=listening)
        self._last_command = 0.0
        self.stopped_at = 0.0
        self.rehearsing = False
        self._behind: set[str] = set()

    @property
    def velocities(self) -> tuple[float, float]:
        """What the robot is asked to hold now, m/s and rad/s."""
        return self._state.velocities()

    @property
    def moving(self) -> bool:
        """Whether the robot is asked to move."""
        return self._state.moving

    @property
    def listening(self) -> bool:
        """Whether commands are obeyed."""
        return self._state.listening

    def hear(self, event: Utterance | Partial, late: bool = False) -> None:
        """Obey an utterance if it is accepted; halt at what may be a command that stops.

        Args:
            event: what was heard.
            late: whether it is out of date; then it can move nothing.
        """
        if isinstance(event, Partial):
            self.emit(event)
            # A needless halt is better than a late one, and what else it was is settled later.
            if not obey_safely(self._state, event.text, self._safety).state.moving:
                self.halt()
        elif not event.accepted:
            self.emit(replace(event, obeyed=False))
        else:
            late = late or event.end < self.stopped_at or event.source in self._behind
            why: Ignored | None = "too_late" if late else "rehearsal" if self.rehearsing else None
            self._obey(replace(event, ignored=why) if why else event)

    def late_from(self, source: str, behind: bool) -> None:
        """Note whether a source is behind, so that what it hears was said long ago."""
        (self._behind.add if behind else self._behind.discard)(source)

    def halt(self) -> None:
        """Ask the robot to stand still from now on."""
        self._state = halt(self._state)

    def stop(self, now: float, why: str, good: bool = False) -> None:
        """End the motion until a new command, and say why.

        Args:
            now: the time of the run, s.
            why: for people.
            good: whether that is good news.
        """
        self.halt()
        self.stopped_at = now
        self.emit(Warning(now, why, good))

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
        """Obey an accepted utterance, unless it is to be ignored."""
        outcome = obey_safely(self._state, utterance.text, self._safety)
        if utterance.ignored and not _harmless(utterance, outcome):
            self.emit(replace(utterance, obeyed=False))
        elif not outcome.obeyed:
            self.emit(replace(utterance, obeyed=False, ignored="not_listening"))
        else:
            self.emit(replace(utterance, obeyed=True, ignored=None))
            self._last_command = utterance.t
            self._state = outcome.state
            if outcome.selected_object is not None:
                self.emit(SelectedObject(utterance.t, outcome.selected_object))
            if outcome.reply is not None:
                self.emit(Reply(utterance.t, outcome.reply))


def _harmless(utterance: Utterance, outcome: Outcome) -> bool:
    """Whether a command may be obeyed though it is to be ignored.

    Over its own voice the robot hears nothing else well enough than `stop`. What comes too late may
    still end the motion, and begin or end the listening.
    """
    if utterance.ignored == "too_late":
        return not outcome.state.moving and outcome.selected_object is None
    return utterance.text == STOP
