"""`false_alarms_per_hour`, set during a run, and the commands that are missed for it."""

from __future__ import annotations

from voz.apps.web.event_history import Record
from voz.errors import ConfigError
from voz.recognition.confidence import MissRate, miss_rate_at
from voz.recognition.engine import RecognitionEngine, confidence_model
from voz.run.clocks import Warn
from voz.settings import Recognition


class FalseAlarmSetting:
    """Sets `false_alarms_per_hour` of a recognizer for the run. Event-loop thread only."""

    def __init__(self, recognizer: RecognitionEngine, settings: Recognition, warn: Warn) -> None:
        """Begin with the value of the settings; `warn` reports each change."""
        self._recognizer = recognizer
        self._settings = settings
        self._warn = warn
        self._first = (
            settings.false_alarms_per_hour or confidence_model(recognizer).default_alarm_rate
        )
        self.alarms = self._first

    @property
    def problem(self) -> str | None:
        """Why it cannot be set; None if it can."""
        if self._settings.threshold is not None:
            return "a threshold is set in its place: leave it out of voz.toml and the command line"
        if not self._costs:
            return (
                f"{self._settings.confidence} does not say how many commands are missed: make it "
                "again with `voz fit-confidence`"
            )
        return None

    def choices(self) -> Record:
        """The values that it may have, each with the share of commands that is missed."""
        costs = {cost.alarms: cost.missed for cost in self._costs}
        known = miss_rate_at(self._costs, self._first)
        stops = {**costs, **({} if known is None else {self._first: round(known, 4)})}
        return {"stops": sorted(stops.items()), "problem": self.problem}

    def set(self, alarms: float) -> None:
        """Allow so many false alarms per hour, from the next utterance on.

        Raises:
            ConfigError: it cannot be set, or not to this value.
        """
        if self.problem:
            raise ConfigError(self.problem)
        if miss_rate_at(self._costs, alarms) is None:
            lowest, highest = self._costs[0].alarms, self._costs[-1].alarms
            raise ConfigError(f"choose false alarms per hour from {lowest:g} to {highest:g}")
        if alarms != self.alarms:
            self._recognizer.set_false_alarm_rate(alarms)
            self.alarms = alarms
            self._warn(f"false_alarms_per_hour is {alarms:g} from now on, for this run", good=True)

    @property
    def _costs(self) -> tuple[MissRate, ...]:
        return confidence_model(self._recognizer).costs
