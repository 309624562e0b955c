"""The status on `/diagnostics`: velocity, last command, listeners, trouble."""

from __future__ import annotations

from collections.abc import Sequence

from voz.events import Event, Notice, Twist, Utterance
from voz.robot.console import motion_in_words
from voz.ros2.message_types import DiagnosticStatus, KeyValue

OK, WARN = 0, 1

WARNING_SHOWN_TIME = 10.0
"""How long a warning is shown, s; a slow monitor sees it too."""


class Diagnosis:
    """Makes a status from events."""

    def __init__(self) -> None:
        self._velocity = (0.0, 0.0)
        self._heard = ""
        self._confidence = 0.0
        self._obeyed = 0
        self._refused = 0
        self._warning: Notice | None = None

    def receive(self, event: Event) -> None:
        """Take an event."""
        if isinstance(event, Twist):
            self._velocity = (event.linear, event.angular)
        elif isinstance(event, Notice):
            self._warning = self._warning if event.good else event
        elif isinstance(event, Utterance):
            self._heard, self._confidence = event.text, event.confidence
            self._obeyed += event.obeyed is True
            self._refused += not event.obeyed

    def status(self, now: float, listeners: Sequence[str], trouble: str | None) -> DiagnosticStatus:
        """Return the status at a time of the run, s."""
        warning = self._warning
        if trouble is None and warning and now - warning.t < WARNING_SHOWN_TIME:
            trouble = warning.text
        linear, angular = self._velocity
        values = {
            "linear": f"{linear:g}",
            "angular": f"{angular:g}",
            "last heard": self._heard,
            "confidence": f"{self._confidence:.2f}",
            "obeyed": str(self._obeyed),
            "refused": str(self._refused),
            "listeners": ", ".join(listeners),
        }
        return DiagnosticStatus(
            level=WARN if trouble else OK,
            name="voz: voice control",
            message=trouble or f"robot {motion_in_words(linear, angular)}",
            hardware_id="voz",
            values=[KeyValue(key, value) for key, value in values.items()],
        )
