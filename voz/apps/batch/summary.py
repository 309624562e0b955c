"""What a run came to, and how well the recordings of a manifest were understood. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from voz.apps.batch.outcomes import Outcome, SilentRow, UtteranceRow
from voz.apps.evaluation.results import Result, Understood, empty_result
from voz.apps.recordings.manifest import Clip
from voz.files import shown_path


@dataclass
class Totals:
    """What outcomes add up to."""

    files: int = 0  # recordings
    failed: int = 0  # recordings that could not be read to their end
    silent: int = 0  # recordings with nothing in them
    utterances: int = 0
    accepted: int = 0  # utterances
    seconds: float = 0.0  # how much was heard, s
    cpu: float = 0.0  # processor time, s

    def add(self, outcome: Outcome) -> None:
        """Count one more recording."""
        heard = [row for row in outcome.rows if isinstance(row, UtteranceRow)]
        self.files += 1
        self.failed += outcome.failed
        self.silent += isinstance(outcome.rows[0], SilentRow)
        self.utterances += len(heard)
        self.accepted += sum(row.accepted for row in heard)
        self.seconds += outcome.seconds
        self.cpu += outcome.cpu

    def lines(self, took: float) -> list[str]:
        """Write it in words; `took` is the duration of the run, s."""
        hours = self.seconds / 3600
        each = f", {hours / (self.cpu / 3600):.0f} hours of sound per core-hour" if self.cpu else ""
        return [
            f"{self.files:,} recordings, {hours:.2f} h of sound in {took:.0f} s{each}",
            f"{self.utterances:,} utterances, {self.accepted:,} accepted; {self.silent:,} "
            f"recordings with nothing in them, {self.failed:,} that could not be read",
        ]


def results_for_clips(clips: Iterable[Clip], outcomes: Mapping[str, Outcome]) -> Iterator[Result]:
    """Combine manifests with outcomes, by the name of the recording in results.

    Stretches of streams are left to `voz eval`.
    """
    for clip in clips:
        outcome = outcomes.get(shown_path(clip.path))
        if clip.start is None and outcome is not None and not outcome.failed:
            yield _result(clip, outcome)


def _result(clip: Clip, outcome: Outcome) -> Result:
    heard = [row for row in outcome.rows if isinstance(row, UtteranceRow)]
    return replace(
        empty_result(clip),
        heard=tuple(Understood(h.text, h.confidence, h.accepted, h.start, h.end) for h in heard),
        seconds=outcome.seconds,
        cpu=outcome.cpu,
    )
