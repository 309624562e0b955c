"""Learns the microphone and the speaker: where the cepstral mean starts, from what was understood.

A microphone, a room and a voice add nearly the same to the cepstra of every frame, and the decoder
takes off what they add on average. One command is too short to find that out; over many it is
the mean of what was heard, less what the acoustic model expects of the phones that were said. The
latter matters: the mean of the sound alone takes the vowel of a `stop` for the microphone. As long
as only `stop` is said, it costs 14 of 100, and this nothing.

`StartVector` is pure; `Aligner` holds a decoder.
"""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace

from voz.audio import Samples
from voz.language.acoustics.acoustic_model import CEPSTRA, AcousticModel, Floats, Indices
from voz.recognition.decoder import load_decoder, process
from voz.recognition.language import Language
from voz.records import CheckedRecord, Fraction

LIKE_THE_MODEL = -1.5
"""What is learnt from fits its command almost as well as any phones: nats for each frame of speech.

So do four of five right commands, half of those of a microphone that is not yet known, and of 195
utterances in 37 minutes of people's talk six. A confidence tells them no better, and it is low
where there is the most to learn.
"""

PRIOR = 100
"""Frames that the usual start counts for: as much as two commands."""

LONGEST = 100
"""Frames that one utterance counts for at most, so that a long wrong one weighs like the others."""

MEMORY = 1500
"""Frames that all utterances count for at most; of what was learnt, the oldest fades."""

LIMITS = np.array([15.0, 45, 45, 45, 30, 30, 25, 25, 20, 20, 20, 20, 20])
"""How far the start may go from the usual one.

A telephone band, the worst microphone among the recordings, moves the second to fourth number by
24 to 38 and the others by up to 27. The first is the level: 20 dB less are 14, and following it
further loses clean commands to the silence around them.
"""

DOUBTS = 4
"""So many utterances understood from the usual start alone, and what was learnt is forgotten."""

LATELY = 10
"""Utterances, about, over which it is counted how many could be learnt from."""

MANY = 1 / 3
"""Share of them from which all that is learnt counts in full; with fewer, it counts less.

Of commands through an unknown microphone a quarter to two thirds can be learnt from, of talk one in
thirty: what is found there is chance, and in an hour it would add up.
"""


def teaches(values: Mapping[str, float], trust: float) -> bool:
    """Tell whether an utterance can be learnt from.

    Args:
        values: its features; none if it fits no command.
        trust: how far it is to be trusted to be speech, 0 to 1.
    """
    return trust > 0 and values.get("phones", -np.inf) >= LIKE_THE_MODEL


Shift = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]


class Observation(msgspec.Struct, frozen=True):
    """What one utterance says about the microphone and the speaker.

    Attributes:
        shift: where the mean should have started, less where it usually starts; 13 numbers.
        frames: the frames of speech, 10 ms each.
    """

    shift: tuple[float, ...]
    frames: int


class StartVector(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What has been learnt so far about one microphone and speaker.

    Attributes:
        shift: the mean of the observations; 13 numbers.
        frames: how many frames it stands for.
        doubts: what speaks against it, from 0; it is forgotten before `DOUBTS` is reached.
        share: how many of the utterances lately could be learnt from, 0 to 1.
    """

    shift: Annotated[tuple[Shift, ...], msgspec.Meta(min_length=CEPSTRA, max_length=CEPSTRA)] = (
        0.0,
    ) * CEPSTRA
    frames: Annotated[float, msgspec.Meta(ge=0, le=MEMORY)] = 0.0
    doubts: Annotated[int, msgspec.Meta(ge=0, lt=DOUBTS)] = 0
    share: Fraction = 0.25

    def moved(self, start: str) -> str:
        """Move the usual start by what was learnt.

        Args:
            start: where the mean usually starts, as pocketsphinx's `set_cmn` reads it.

        Returns:
            Where it is to start now; the same text while nothing has been learnt.
        """
        if not self.frames:
            return start
        # Weighed against the usual start, which is a shift of 0.
        shift = np.array(self.shift) * self.frames / (self.frames + PRIOR)
        return ",".join(f"{number:.2f}" for number in start_numbers(start) + shift)

    def updated(self, observed: Observation) -> StartVector:
        """Learn from an utterance that is surely a command, which also settles one doubt."""
        weight = min(observed.frames, LONGEST) * min(1.0, self.share / MANY)
        frames = self.frames + weight
        shift = (self.frames * np.array(self.shift) + weight * np.array(observed.shift)) / frames
        # What lies outside the limits would take as long to unlearn as it took to learn.
        shift = np.clip(shift, -LIMITS, LIMITS)
        share = self.share + (1 - self.share) / LATELY
        doubts = max(self.doubts - 1, 0)
        return StartVector(tuple(shift.tolist()), min(frames, MEMORY), doubts, share)

    def passed(self) -> StartVector:
        """Note an utterance that nothing can be learnt from."""
        return replace(self, share=self.share - self.share / LATELY)

    def doubted(self) -> StartVector:
        """Note an utterance that only the usual start understands; forget all at `DOUBTS`."""
        if self.doubts + 1 >= DOUBTS:
            return StartVector()
        return replace(self, doubts=self.doubts + 1)


class Aligned(NamedTuple):
    """The phones of a sentence in its sound.

    Attributes:
        cepstra: of all frames, before any mean is taken off, shape (n, 13).
        at: the frames of speech, shape (m,).
        phones: the phone in each of them, by its number in the acoustic model, shape (m,).
        senones: its state, likewise.
    """

    cepstra: Floats
    at: Indices
    phones: Indices
    senones: Indices


class Aligner:
    """Finds the phones of a known sentence in the sound, and what they say about the microphone.

    Attributes:
        model: the acoustic model.
    """

    def __init__(self, language: Language) -> None:
        """Load the models; raises LanguageError as `Decoder` does."""
        # pocketsphinx hands out the cepstra as files alone.
        folder = tempfile.mkdtemp(prefix="voz-")
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        self._cepstra = Path(folder)
        self._decoder = load_decoder(language, bestpath=False, mfclogdir=folder)
        self.model = AcousticModel(language.spoken.folder(language.files.folder))

    def align(self, samples: Samples, text: str, start: str) -> Aligned | None:
        """Find the phones.

        Args:
            samples: one utterance, 16 kHz.
            text: what was said; its words are in the dictionary.
            start: where the cepstral mean starts, as `set_cmn` reads it.

        Returns:
            The phones; None if the sentence cannot be aligned with the sound.
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
        self, samples: Samples, text: str, start: str, learnt: StartVector
    ) -> Observation | None:
        """Compare an utterance with what the acoustic model expects of its phones.

        Args:
            samples: as for `align`.
            text: as for `align`.
            start: where the cepstral mean usually starts.
            learnt: what was learnt before: the better the start, the better the alignment.

        Returns:
            The observation; None if the sentence cannot be aligned with the sound.
        """
        aligned = self.align(samples, text, learnt.moved(start))
        if aligned is None:
            return None
        expected = self.model.expected(aligned.phones, aligned.senones)
        heard = aligned.cepstra[aligned.at] - start_numbers(start)
        shift = (heard - expected).mean(axis=0)
        return Observation(tuple(shift.tolist()), len(aligned.at))

    def _process(self, samples: Samples, start: str) -> Floats:
        """Search one utterance; returns its cepstra before the mean is taken off, shape (n, 13)."""
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
