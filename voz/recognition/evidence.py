"""The likelihoods of a command, of its rivals and of any phones, by pocketsphinx."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from voz.audio import Samples
from voz.recognition.decoder import load_decoder, process
from voz.recognition.language import Language
from voz.recognition.phone_loop import filler_dictionary
from voz.recognition.search_graph import SILENCE, search_graph
from voz.recognition.shortlist import Shortlist

UNPRUNED = 0.0
"""An infinite beam: long sentences may be 800 nats apart, and a beam of 1e-300 is 690."""

SCORE_UNIT = 1024 * math.log(1.0001)
"""Nats of an acoustic score: 1.0001-logarithms (`logmath.h`) shifted by 10 bits (`hmm.h`)."""

MAX_RIVALS = 60
"""Most commands that are searched; of more, those that sound like the text."""

NEVER_MISSED_TOLERANCE = 1.1
"""A command that must not be missed wins although it is worse by this, nats per frame."""

MIN_COVERAGE = 0.75
"""If its words cover this share of the speech that the better command covers."""


class Span(NamedTuple):
    """A word (with its variant: `the(2)`) or phone of a path."""

    name: str
    start: int  # first frame, 10 ms each
    end: int  # last frame
    score: float  # log-likelihood relative to the best state of each frame, nats

    @property
    def frames(self) -> int:
        """Its duration in frames."""
        return self.end - self.start + 1


@dataclass(frozen=True)
class Alignment:
    """The best path of a part of the search: its score in nats, and its spans without silences."""

    score: float
    spans: tuple[Span, ...]

    @property
    def frames(self) -> int:
        """Its duration in frames without silences."""
        return sum(span.frames for span in self.spans)


@dataclass(frozen=True)
class Evidence:
    """The likelihoods for an utterance."""

    text: str
    command: Alignment
    rivals: dict[str, float]  # scores of other commands, nats
    phones: Alignment  # the path of any phones


class CommandSearch:
    """One unpruned search of commands and a free loop of phones, so that scores are comparable."""

    def __init__(
        self,
        language: Language,
        never_missed: Collection[str] = (),
        mllr: str | None = None,
    ) -> None:
        """Load the model; LanguageError if pocketsphinx cannot use the dictionary.

        Args:
            language: the commands.
            never_missed: commands that win when in doubt.
            mllr: file with a speaker's transform of the acoustic model.
        """
        # Fillers keep their context-independent models, which take a third of the time.
        # The search then must not put them everywhere; the silences are in its arcs.
        self._phones = sorted(language.spoken.phones)
        with filler_dictionary(self._phones) as words:
            self._decoder = load_decoder(
                language,
                bestpath=False,
                mllr=mllr,
                fdict=str(words),
                fsgusefiller=False,
                beam=UNPRUNED,
                pbeam=UNPRUNED,
                wbeam=UNPRUNED,
            )
        self._shortlist = Shortlist(language, never_missed, MAX_RIVALS)
        if self.finds_alone:
            self._search_for(language.commands.listed)

    @property
    def finds_alone(self) -> bool:
        """Whether it searches all commands, and needs no proposal."""
        return self._shortlist.is_whole

    def compare(self, samples: Samples, text: str, start: str) -> Evidence | None:
        """Collect the evidence for a command; None if the sound is too short for any.

        Args:
            samples: one utterance, 16 kHz.
            text: the proposed sentence; empty for the best command.
            start: the first cepstral mean, as `mean_start` gives it.
        """
        found, phones = self._scores(samples, text, start)
        if not found or not phones.spans:
            return None
        best = text if text in found else max(found, key=found.__getitem__)
        best = self._prefer_never_missed(best, found, phones)
        del found[best]
        return Evidence(best, self._path(self._graph.ends[best]), found, phones)

    def others(
        self, samples: Samples, text: str, start: str, best: str, count: int
    ) -> list[Evidence]:
        """Search again, and collect the evidence for so many commands that come next to the best.

        Args:
            samples: as for `compare`, like `text` and `start`.
            text: the proposed sentence.
            start: the first cepstral mean.
            best: the command that `compare` found.
            count: how many others.
        """
        scores, phones = self._scores(samples, text, start)
        scores.pop(best, None)
        nearest = sorted(scores, key=scores.__getitem__, reverse=True)[:count]
        return [Evidence(one, self._path(self._graph.ends[one]), {}, phones) for one in nearest]

    def _scores(
        self, samples: Samples, text: str, start: str
    ) -> tuple[dict[str, float], Alignment]:
        """The scores of the commands that fit, nats, and the path of any phones."""
        if not self.finds_alone:
            self._search_for(self._shortlist.similar_to(text))
        process(self._decoder, samples, start)
        scores = {command: self._score(end) for command, end in self._graph.ends.items()}
        found = {command: score for command, score in scores.items() if score is not None}
        return found, self._path(self._graph.loop)

    def _prefer_never_missed(
        self, best: str, scores: Mapping[str, float], phones: Alignment
    ) -> str:
        """A command that must not be missed if it is close to the best one, else that."""
        least = scores[best] - NEVER_MISSED_TOLERANCE * phones.frames
        close = [c for c in self._shortlist.never_missed if scores.get(c, -math.inf) > least]
        if best in close or not close:
            return best
        careful = max(close, key=scores.__getitem__)
        explained = covered(self._path(self._graph.ends[best]), phones)
        enough = covered(self._path(self._graph.ends[careful]), phones) >= MIN_COVERAGE * explained
        return careful if enough else best

    def _search_for(self, commands: list[str]) -> None:
        self._graph = search_graph(commands, self._phones)
        found = self._decoder.create_fsg("all", 0, self._graph.loop, self._graph.arcs)
        self._decoder.add_fsg("all", found)
        self._decoder.activate_search("all")
        self._search = self._decoder.get_fsg("all")

    def _score(self, end: int) -> float | None:
        self._search.set_final_state(end)
        hypothesis = self._decoder.hyp()
        return _nats(hypothesis.score) if hypothesis else None

    def _path(self, end: int) -> Alignment:
        score = self._score(end)
        spans = (
            Span(s.word, s.start_frame, s.end_frame, _nats(s.ascore))
            for s in self._decoder.seg() or ()
            if s.word not in (SILENCE, "(NULL)")
        )
        return Alignment(-math.inf if score is None else score, tuple(spans))


def covered(command: Alignment, phones: Alignment) -> int:
    """The frames of speech, by the phone loop, in which a command has a word."""
    return sum(overlap(word, span) for word in command.spans for span in phones.spans)


def overlap(one: Span, other: Span) -> int:
    """The frames that two spans share."""
    return max(0, min(one.end, other.end) - max(one.start, other.start) + 1)


def _nats(score: float) -> float:
    """Undo `logmath.exp`, by which pocketsphinx's Python returns scores."""
    return math.log(score) / math.log(1.0001) * SCORE_UNIT
