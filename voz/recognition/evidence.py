"""What speaks for a command and against it: its own path, its rivals', and that of any phones."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import NamedTuple

from voz.audio import Samples
from voz.recognition.decoder import load_decoder, process
from voz.recognition.language import Language
from voz.recognition.phone_loop import fillers
from voz.recognition.search_graph import SILENCE, search_graph
from voz.recognition.shortlist import Shortlist

UNPRUNED = 0.0
"""A beam without an end.

A sentence of 15 words may be 800 nats better or worse than the phone loop, and the narrowest
double, 1e-300, stands for 690: then one of the two was lost, and the command with it.
"""

SCORE_UNIT = 1024 * math.log(1.0001)
"""pocketsphinx counts acoustic scores in 1.0001-logarithms shifted right by 10 bits; this in nats.

`logmath.h` has the base, `SENSCR_SHIFT` in `hmm.h` the shift.
"""

MOST_RIVALS = 60
"""Commands searched side by side; of longer lists, those that sound most like what was heard."""

IN_DOUBT = 1.1
"""A command that must not be missed is taken when it is worse by so little, nats for each frame."""

EXPLAINS = 0.75
"""And when it has a word in so much of the speech that the better command has words in.

Of 18 times that `stop` was said and another command fitted better, 16 are within both, and of 650
other commands none. Without the second three are, and in kitchen noise nine of 280, most of them
`stop speech`.
"""


class Span(NamedTuple):
    """A word or phone of a path.

    Attributes:
        name: the word as the dictionary has it, with its variant: `stop`, `the(2)`.
        start: its first frame, 10 ms each.
        end: its last frame.
        score: its log-likelihood relative to the best state of each frame, nats.
    """

    name: str
    start: int
    end: int
    score: float

    @property
    def frames(self) -> int:
        """How many frames it takes."""
        return self.end - self.start + 1


class Alignment(NamedTuple):
    """The best way through one part of the search: its score in nats, and all but its silences."""

    score: float
    spans: tuple[Span, ...]

    @property
    def frames(self) -> int:
        """How many frames it takes without its silences."""
        return sum(span.frames for span in self.spans)


class Evidence(NamedTuple):
    """What is known about one utterance.

    Attributes:
        text: the command that it is about.
        command: the path of that command.
        rivals: the scores of other commands, nats.
        phones: the path of any sequence of phones.
    """

    text: str
    command: Alignment
    rivals: dict[str, float]
    phones: Alignment


class Comparison:
    """Searches the commands and a free loop of phones side by side.

    All are scored against the same best state of each frame, and their results are read one after
    the other. Separate searches with `compallsen`, which makes separate scores comparable, tell
    commands from other speech no better and take four times as long. Nothing is pruned, so there
    is always a result, and a pruned search beforehand finds no more commands.
    """

    def __init__(
        self,
        language: Language,
        never_missed: Collection[str] = (),
        mllr: str | None = None,
    ) -> None:
        """Load the model.

        Args:
            language: whose commands it compares.
            never_missed: those that are taken when in doubt.
            mllr: a file with the transform of the acoustic model for a speaker.

        Raises:
            LanguageError: pocketsphinx cannot use the dictionary.
        """
        # As fillers the phones keep their context-independent models: a third of the time.
        # The search then must not put them everywhere; the silences are in its arcs.
        self._phones = sorted(language.spoken.phones)
        with fillers(self._phones) as words:
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
        self._shortlist = Shortlist(language, never_missed, MOST_RIVALS)
        if self.finds_alone:
            self._search_for(language.commands.listed)

    @property
    def finds_alone(self) -> bool:
        """Whether it can find the command too: the list is short enough to search all of it."""
        return self._shortlist.is_whole

    def compare(self, samples: Samples, text: str, start: str) -> Evidence | None:
        """Collect the evidence for a command.

        Args:
            samples: one utterance, 16 kHz.
            text: the sentence that was heard; empty takes the command that fits best.
            start: where the cepstral mean starts, as `mean_start` gives it.

        Returns:
            The evidence; None if the sound is too short for any command.
        """
        if not self.finds_alone:
            self._search_for(self._shortlist.similar_to(text))
        process(self._decoder, samples, start)
        scores = {command: self._score(end) for command, end in self._graph.ends.items()}
        found = {command: score for command, score in scores.items() if score is not None}
        phones = self._path(self._graph.loop)
        if not found or not phones.spans:
            return None
        best = text if text in found else max(found, key=found.__getitem__)
        best = self._in_doubt(best, found, phones)
        del found[best]
        return Evidence(best, self._path(self._graph.ends[best]), found, phones)

    def _in_doubt(self, best: str, scores: Mapping[str, float], phones: Alignment) -> str:
        """Rather a command that must not be missed than one that is hardly better."""
        least = scores[best] - IN_DOUBT * phones.frames
        close = [c for c in self._shortlist.never_missed if scores.get(c, -math.inf) > least]
        if best in close or not close:
            return best
        careful = max(close, key=scores.__getitem__)
        explained = covered(self._path(self._graph.ends[best]), phones)
        enough = covered(self._path(self._graph.ends[careful]), phones) >= EXPLAINS * explained
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
    """Count the frames of speech, as the phone loop has it, in which a command has a word too."""
    return sum(overlap(word, span) for word in command.spans for span in phones.spans)


def overlap(one: Span, other: Span) -> int:
    """Count the frames that two spans share."""
    return max(0, min(one.end, other.end) - max(one.start, other.start) + 1)


def _nats(score: float) -> float:
    """Back from `logmath.exp(score)`, which is how pocketsphinx's Python hands scores out."""
    return math.log(score) / math.log(1.0001) * SCORE_UNIT
