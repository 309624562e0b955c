"""What a run came to, in a few lines; and how well what a manifest lists was understood. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from voz.apps.batch.outcomes import Outcome, SilentRow, UtteranceRow
from voz.apps.evaluation.results import Result, Understood, empty_result
from voz.apps.recordings.clips import Clip
from voz.files import shown_path


@dataclass
class Totals:
    """What outcomes add up to.

    Attributes:
        files: how many recordings.
        failed: how many of them could not be read to their end.
        silent: how many have nothing in them.
        utterances: in all of them.
        accepted: how many of these were recognized surely enough.
        seconds: how much was heard, s.
        cpu: processor time that took, s.
    """

    files: int = 0
    failed: int = 0
    silent: int = 0
    utterances: int = 0
    accepted: int = 0
    seconds: float = 0.0
    cpu: float = 0.0

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
        """Say it in words.

        Args:
            took: how long the run was, s.
        """
        hours = self.seconds / 3600
        each = f", {hours / (self.cpu / 3600):.0f} hours of sound per core-hour" if self.cpu else ""
        return [
            f"{self.files:,} recordings, {hours:.2f} h of sound in {took:.0f} s{each}",
            f"{self.utterances:,} utterances, {self.accepted:,} accepted; {self.silent:,} "
            f"recordings with nothing in them, {self.failed:,} that could not be read",
        ]


def results_for_clips(clips: Iterable[Clip], outcomes: Mapping[str, Outcome]) -> Iterator[Result]:
    """Put what was heard beside what was said; stretches of streams are left to `voz eval`.

    Args:
        clips: what was said.
        outcomes: what was heard, by the name of the recording in results.
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
