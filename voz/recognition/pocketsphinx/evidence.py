"""The likelihoods of a command, of its rivals and of any phones, by pocketsphinx."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import NamedTuple

from voz.audio import Samples
from voz.language.acoustic_model import SILENCE_PHONE
from voz.language.grammar import FsgArc
from voz.language.phones import read_distances
from voz.recognition.language import Language, Shortlist
from voz.recognition.pocketsphinx.decoder import load_decoder, nats, process
from voz.recognition.thresholds import MIN_COVERAGE, NEVER_MISSED_TOLERANCE

SILENCE = "<sil>"

SILENCE_WEIGHT = 0.005
"""pocketsphinx's `silprob`."""


class Graph(NamedTuple):
    """The arcs from state 0, the last state of each command, and the state of the phone loop."""

    arcs: list[FsgArc]
    ends: dict[str, int]
    loop: int


def phone_word(phone: str) -> str:
    """The word of a single phone; no command has an underscore."""
    return f"_{phone}"


def search_graph(commands: Sequence[str], loop: Sequence[str]) -> Graph:
    """Build a prefix tree of commands beside a loop of phones, with silences everywhere."""
    arcs: list[FsgArc] = []
    state = count(1)
    ends = {"": 0}  # of every beginning of a command
    for before, word, after in _steps(commands):
        if after not in ends:
            ends[after] = next(state)
            arcs.append((ends[before], ends[after], 1.0, word))
    any_phones = next(state)
    arcs.append((0, any_phones, 1.0))
    arcs += [(any_phones, any_phones, 1 / len(loop), phone_word(phone)) for phone in loop]
    arcs += [(at, at, SILENCE_WEIGHT, SILENCE) for at in (*ends.values(), any_phones)]
    return Graph(arcs, {command: ends[command] for command in commands}, any_phones)


def _steps(commands: Iterable[str]) -> Iterator[tuple[str, str, str]]:
    """Each word of each command, with the command before it, and with it."""
    for command in commands:
        words = command.split()
        for number, word in enumerate(words):
            yield " ".join(words[:number]), word, " ".join(words[: number + 1])


@contextmanager
def filler_dictionary(phones: Iterable[str]) -> Iterator[Path]:
    """Write a dictionary of silences and phones, and delete it afterward."""
    words = [f"{word} {SILENCE_PHONE}" for word in ("<s>", "</s>", SILENCE)]
    words += [f"{phone_word(phone)} {phone}" for phone in phones]
    with tempfile.NamedTemporaryFile(
        "w", prefix="voz-", suffix=".filler_dictionary", encoding="utf-8"
    ) as file:
        file.write("".join(f"{line}\n" for line in words))
        file.flush()
        yield Path(file.name)


UNPRUNED = 0.0
"""An infinite beam: long sentences may be 800 nats apart, and a beam of 1e-300 is 690."""

MAX_RIVALS = 60
"""Most commands that are searched; of more, those that sound like the text."""


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

    def __init__(self, language: Language, never_missed: Collection[str] = ()) -> None:
        """Load the model; LanguageError if pocketsphinx cannot use the dictionary.

        Of two commands that are close one of `never_missed` wins.
        """
        # Fillers keep their context-independent models, which take a third of the time.
        # The search then must not put them everywhere; the silences are in its arcs.
        self._phones = sorted(language.spoken.phones)
        with filler_dictionary(self._phones) as words:
            self._decoder = load_decoder(
                language,
                bestpath=False,
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
        return self._shortlist.compares_all

    def compare(self, samples: Samples, text: str, start: str) -> Evidence | None:
        """Collect the evidence for a command; None if the sound is too short for any.

        The samples are one utterance, 16 kHz; an empty text is the best command. `start` is the
        first cepstral mean, as `mean_start` gives it.
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
        """Search again, and collect the evidence for `count` commands next to the `best` one.

        The other arguments are those of `compare`.
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
        never_missed = max(close, key=scores.__getitem__)
        explained = covered(self._path(self._graph.ends[best]), phones)
        enough = (
            covered(self._path(self._graph.ends[never_missed]), phones) >= MIN_COVERAGE * explained
        )
        return never_missed if enough else best

    def _search_for(self, commands: list[str]) -> None:
        self._graph = search_graph(commands, self._phones)
        found = self._decoder.create_fsg("all", 0, self._graph.loop, self._graph.arcs)
        self._decoder.add_fsg("all", found)
        self._decoder.activate_search("all")
        self._search = self._decoder.get_fsg("all")

    def _score(self, end: int) -> float | None:
        self._search.set_final_state(end)
        hypothesis = self._decoder.hyp()
        return nats(hypothesis.score) if hypothesis else None

    def _path(self, end: int) -> Alignment:
        score = self._score(end)
        spans = (
            Span(s.word, s.start_frame, s.end_frame, nats(s.ascore))
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


IGNORED_FRAMES_AFTER = 5
"""Frames of other sound after a command that do not count: a breath."""

HURRY_TOLERANCE = 0.3
"""In log durations: a word in three quarters of its usual time is not hurried."""

CLEAR_SNR = 30.0
"""Signal-to-noise ratio above which the room does not count, dB."""

MAX_NOISE = 2.0
"""Tens of dB below `CLEAR_SNR` beyond which nothing changes."""


def features(
    evidence: Evidence,
    phones_of: Mapping[str, Sequence[str]],
    usual: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Compute features that mean the same for any list of commands, by their names.

    Likelihood ratios are in nats per frame of speech; `usual` are the frames that each phone takes,
    None for those of English.
    """
    command, phones = evidence.command, evidence.phones
    usual = usual or read_distances().frames
    words = _spoken_words(command.spans, phones_of)
    after = sum(max(0, p.end - max(p.start - 1, command.spans[-1].end)) for p in phones.spans)
    slowness = min(_pace(word, said, usual) for word, said in words)
    return {
        "phones": (command.score - phones.score) / phones.frames,
        "worst word": min(word_ratio(word, phones) for word, _ in words),
        "hurried": max(0.0, -slowness - HURRY_TOLERANCE),
        "not covered": 1 - covered(command, phones) / phones.frames,
        "sound after": math.log1p(max(0, after - IGNORED_FRAMES_AFTER)),
    }


def voices_around(above: float, voices: float) -> float:
    """The feature for voices in the room, which phones explain better than the command does.

    `above` is the signal-to-noise ratio, dB, `voices` the share of the time with voices, 0 to 1. It
    is 0 for a quiet room, above it amid voices and below it amid other noise.
    """
    return (2 * voices - 1) * min(MAX_NOISE, max(0.0, (CLEAR_SNR - above) / 10))


def word_ratio(word: Span, phones: Alignment) -> float:
    """A word's log-likelihood ratio to the phones in its frames, nats per frame."""
    against = sum(overlap(word, span) * span.score / span.frames for span in phones.spans)
    return (word.score - against) / word.frames


def _spoken_words(
    spans: Sequence[Span], phones_of: Mapping[str, Sequence[str]]
) -> list[tuple[Span, Sequence[str]]]:
    """The words of a command with their phones; one of a single phone joins the word before it."""
    words: list[tuple[Span, Sequence[str]]] = []
    for span in spans:
        said = phones_of[span.name]
        if len(said) == 1 and words:
            before, phones = words.pop()
            score = before.score + span.score
            words.append((Span(before.name, before.start, span.end, score), (*phones, *said)))
        else:
            words.append((span, said))
    return words


def _pace(word: Span, phones: Sequence[str], usual: Mapping[str, float]) -> float:
    """The logarithm of a word's time over what its phones usually take."""
    return math.log(word.frames / sum(usual[phone] for phone in phones))
