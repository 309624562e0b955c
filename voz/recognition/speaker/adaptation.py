"""What is learned of a speaker and a microphone, by commands and what the model expects of them.

That is where the cepstral mean starts, and a linear transform of the acoustic model's means (MLLR):
C. J. Leggetter, P. C. Woodland: Maximum likelihood linear regression for speaker adaptation of
continuous density hidden Markov models, Computer Speech & Language 9 (1995). One transform serves
all phones.
"""

from __future__ import annotations

import re
import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace

from voz.audio import Samples
from voz.language.acoustic_model import CEPSTRA, FEATURE_STREAMS, AcousticModel, Floats, Indices
from voz.recognition.language import Language
from voz.recognition.pocketsphinx.decoder import load_decoder, process
from voz.records import CheckedRecord, Fraction

MIN_PHONES_RATIO = -1.5
"""Feature `phones` of an utterance that is learned from, nats per frame; four of five commands are
above it.
"""

PRIOR_FRAMES = 100
"""Weight of the usual start, frames: about two commands."""

MAX_FRAMES_PER_UTTERANCE = 100
"""Most weight of an utterance, frames: long ones are wrong as often as short ones."""

MAX_FRAMES = 1500
"""Most weight of all utterances, frames; the oldest fade."""

MAX_SHIFT = np.array([15.0, 45, 45, 45, 30, 30, 25, 25, 20, 20, 20, 20, 20])
"""Most that the start may move; a telephone moves it by up to 38."""

MAX_DOUBTS = 4
"""All is forgotten after this many utterances that only the usual start understands."""

SHARE_WINDOW = 10
"""Utterances over which `StartVector.share` is averaged."""

FULL_WEIGHT_SHARE = 1 / 3
"""Share from which an utterance has its full weight: of people's talk, 1 in 30 is learned from."""


def teaches(features: Mapping[str, float], speech_probability: float) -> bool:
    """Whether an utterance is learned from."""
    return speech_probability > 0 and features.get("phones", -np.inf) >= MIN_PHONES_RATIO


Shift = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]


class Observation(msgspec.Struct, frozen=True):
    """Best start less the usual one by one utterance, and its frames of speech, 10 ms each."""

    shift: tuple[float, ...]
    frames: int


class StartVector(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What was learned about one microphone and speaker."""

    shift: Annotated[tuple[Shift, ...], msgspec.Meta(min_length=CEPSTRA, max_length=CEPSTRA)] = (
        0.0,
    ) * CEPSTRA
    frames: Annotated[float, msgspec.Meta(ge=0, le=MAX_FRAMES)] = 0.0  # weight of the shift
    doubts: Annotated[int, msgspec.Meta(ge=0, lt=MAX_DOUBTS)] = 0  # utterances against it
    share: Fraction = 0.25  # of the latest utterances that were learned from

    def moved(self, start: str) -> str:
        """Move the usual start, in the notation of `set_cmn`."""
        if not self.frames:
            return start
        # Weighed against the usual start, which is a shift of 0.
        shift = np.array(self.shift) * self.frames / (self.frames + PRIOR_FRAMES)
        return ",".join(f"{number:.2f}" for number in start_numbers(start) + shift)

    def updated(self, observed: Observation) -> StartVector:
        """Learn from a command, which also settles one doubt."""
        frames = min(observed.frames, MAX_FRAMES_PER_UTTERANCE)
        weight = frames * min(1.0, self.share / FULL_WEIGHT_SHARE)
        total = self.frames + weight
        shift = (self.frames * np.array(self.shift) + weight * np.array(observed.shift)) / total
        # What lies outside the limits would take as long to unlearn as it took to learn.
        shift = np.clip(shift, -MAX_SHIFT, MAX_SHIFT)
        share = self.share + (1 - self.share) / SHARE_WINDOW
        doubts = max(self.doubts - 1, 0)
        return StartVector(tuple(shift.tolist()), min(total, MAX_FRAMES), doubts, share)

    def with_unused(self) -> StartVector:
        """Note an utterance that is not learned from."""
        return replace(self, share=self.share - self.share / SHARE_WINDOW)

    def with_contradiction(self) -> StartVector:
        """Note an utterance that only the usual start understands."""
        if self.doubts + 1 >= MAX_DOUBTS:
            return StartVector()
        return replace(self, doubts=self.doubts + 1)


@dataclass(frozen=True)
class Aligned:
    """The phones of a sentence in its sound, by the acoustic model's numbers."""

    cepstra: Floats  # of all frames, with their mean, shape (n, 13)
    at: Indices  # the frames of speech, shape (m,)
    phones: Indices  # shape (m,)
    senones: Indices  # states of the phones, shape (m,)


class Aligner:
    """Finds the phones of a known sentence, and what they say about the microphone."""

    def __init__(self, language: Language) -> None:
        """Load the models; raises LanguageError."""
        # pocketsphinx hands out the cepstra as files alone.
        folder = tempfile.mkdtemp(prefix="voz-")
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        self._cepstra = Path(folder)
        self._decoder = load_decoder(language, bestpath=False, mfclogdir=folder)
        self.model = AcousticModel(language.spoken.folder(language.files.folder))

    def align(self, samples: Samples, text: str, start: str) -> Aligned | None:
        """Find the phones; None if the sentence cannot be aligned.

        Args:
            samples: one utterance, 16 kHz.
            text: what was said; its words are in the dictionary.
            start: the first cepstral mean, as `set_cmn` reads it.
        """
        if not len(samples):  # pocketsphinx refuses nothing at all
            return None
        try:
            self._decoder.set_align_text(text)
            cepstra = self._process(samples, start)
            # The first search aligns the words; the second needs its result to align the states.
            self._decoder.set_alignment()
            self._process(samples, start)
        except RuntimeError:  # the sound is too short for the sentence, or has no path through it
            return None
        states = [
            (frame, self.model.phones[phone.name], int(state.name))
            for word in self._decoder.get_alignment() or ()
            for phone in word
            if phone.name != "SIL"
            for state in phone
            for frame in range(state.start, state.start + state.duration)
            # As pocketsphinx, which takes no mean off frames without energy.
            if frame < len(cepstra) and cepstra[frame, 0] >= 0
        ]
        return Aligned(cepstra, *np.array(states, np.int64).T) if states else None

    def observe(
        self, samples: Samples, text: str, start: str, learned: StartVector
    ) -> Observation | None:
        """Compare an utterance with what the model expects; arguments as for `align`."""
        aligned = self.align(samples, text, learned.moved(start))
        if aligned is None:
            return None
        expected = self.model.expected(aligned.phones, aligned.senones)
        heard = aligned.cepstra[aligned.at] - start_numbers(start)
        shift = (heard - expected).mean(axis=0)
        return Observation(tuple(shift.tolist()), len(aligned.at))

    def _process(self, samples: Samples, start: str) -> Floats:
        """Search one utterance; returns its cepstra with their mean, shape (n, 13)."""
        process(self._decoder, samples, start)
        # The newest: a search that fails leaves its file behind.
        *failed, written = sorted(self._cepstra.iterdir())
        numbers = np.fromfile(written, ">f4", offset=4)  # the first 4 bytes count them
        for path in (*failed, written):
            path.unlink()
        return numbers.reshape(-1, CEPSTRA).astype(np.float64)


def start_numbers(start: str) -> Floats:
    """Read what `set_cmn` reads: 13 numbers with commas, of which the last may be left out."""
    given = [float(number) for number in start.split(",")]
    return np.array(given + [0.0] * (CEPSTRA - len(given)))


MLLR_PRIOR_FRAMES = 50
"""Weight of the unchanged means, frames."""

MIN_OCCUPANCY = 1e-3
"""Gaussians with a smaller share of a frame are left out."""

_NUMBER = re.compile(r"-?[0-9]{1,9}\.[0-9]{6}", re.ASCII)


class MeanTransform(NamedTuple):
    """Transforms the means of a stream: times `matrix` (13, 13), plus `bias` (13,)."""

    matrix: Floats
    bias: Floats


def fit_transforms(
    spoken: Sequence[tuple[Aligned, str]], model: AcousticModel
) -> tuple[MeanTransform, ...]:
    """Find the transform of each stream, by aligned sentences and their first cepstral means."""
    transforms = []
    for stream in range(FEATURE_STREAMS):
        means, variances = model.means[:, stream], model.variances[:, stream]
        usual = _extended(means.reshape(-1, CEPSTRA))
        spread = MLLR_PRIOR_FRAMES * usual.T @ usual / len(usual)
        # Not the mean: some variances are next to 0, and one of them would outweigh all the rest.
        precision = 1 / np.median(variances, axis=(0, 1))
        squares = precision[:, None, None] * spread
        products = precision[:, None] * spread[1:]
        for aligned, start in spoken:
            more_squares, more_products = _statistics(aligned, start, model, stream)
            squares += more_squares
            products += more_products
        rows = np.linalg.solve(squares, products[:, :, None])[:, :, 0]
        transforms.append(MeanTransform(rows[:, 1:], rows[:, 0]))
    return tuple(transforms)


def as_text(transforms: Sequence[MeanTransform]) -> str:
    """Write transforms as pocketsphinx reads them (`ps_mllr.c`), with unchanged variances."""
    lines = ["1", str(len(transforms))]  # of one class
    for matrix, bias in transforms:
        numbers = [*matrix, bias, np.ones(CEPSTRA)]
        lines += [str(CEPSTRA), *(" ".join(f"{n:.6f}" for n in row) for row in numbers)]
    return "\n".join(lines) + "\n"


def is_transforms(text: str) -> bool:
    """Whether a text is what `as_text` writes."""
    found = text.split()
    one = 1 + CEPSTRA * (CEPSTRA + 2)
    if found[:2] != ["1", str(FEATURE_STREAMS)] or len(found) != 2 + FEATURE_STREAMS * one:
        return False
    sizes, numbers = found[2::one], [n for at in range(one - 1) for n in found[3 + at :: one]]
    return {*sizes} == {str(CEPSTRA)} and all(map(_NUMBER.fullmatch, numbers))


def _statistics(
    aligned: Aligned, start: str, model: AcousticModel, stream: int
) -> tuple[Floats, Floats]:
    """The sums of a sentence for a stream, shapes (13, 14, 14) and (13, 14)."""
    heard = _streams(aligned.cepstra - start_numbers(start))[stream][aligned.at]
    means = model.means[aligned.phones, stream]
    variances = model.variances[aligned.phones, stream]
    weights = model.log_weights(aligned.senones)[stream]
    distances = ((heard[:, None] - means) ** 2 / variances + np.log(variances)).sum(axis=2)
    likely = weights - distances / 2
    shares = np.exp(likely - likely.max(axis=1, keepdims=True))
    shares /= shares.sum(axis=1, keepdims=True)
    frame, gaussian = np.nonzero(shares >= MIN_OCCUPANCY)
    precisions = shares[frame, gaussian, None] / variances[frame, gaussian]
    extended = _extended(means[frame, gaussian])
    squares = np.einsum("ni,nj,nk->ijk", precisions, extended, extended, optimize=True)
    products = np.einsum("ni,nj->ij", precisions * heard[frame], extended)
    return squares, products


def _streams(cepstra: Floats) -> tuple[Floats, Floats, Floats]:
    """The features of pocketsphinx (`1s_c_d_dd`), each of shape (n, 13)."""
    frames = np.arange(len(cepstra))

    def later(by: int) -> Floats:
        return cepstra[np.clip(frames + by, 0, len(cepstra) - 1)]

    return cepstra, later(2) - later(-2), later(3) - later(-1) - later(1) + later(-3)


def _extended(means: Floats) -> Floats:
    """Put a 1 before each mean, for the bias; shape (n, 14)."""
    return np.hstack([np.ones((len(means), 1)), means])
