"""Whether `stop` is heard while the robot speaks, and nothing else is.

Run `python benchmarks/echo.py MANIFEST... [--most N]`. Each `stop` of the manifests is put
somewhere into a reply of the robot's that is heard in a room, 10 dB louder than the speaker, a
little distorted as by a small loudspeaker, and 60 ms late.
"""

from __future__ import annotations

import argparse
import random
from pathlib import Path

import numpy as np
import numpy.typing as npt
from machine import machine

from voz.apps.evaluation.noise import room_response
from voz.apps.recordings.manifest import read_manifests
from voz.audio import SAMPLE_RATE
from voz.audio.capture.sound_files import read_blocks
from voz.config import default_commands
from voz.events import Partial, Utterance
from voz.hearing.half_duplex import HalfDuplex
from voz.language.generated.language_files import find_language
from voz.recognition.recognizer import Recognizer
from voz.settings import Recognition
from voz.speech.speech_cache import cached_speech

LOUDER = 10.0
"""The reply over the speaker, dB."""

LATE = 0.06
"""The sound system's delay, s."""

DISTORTION = 0.15
BLOCK = 480

Floats = npt.NDArray[np.float64]


class Played:
    """A loudspeaker whose time is that of the samples."""

    def __init__(self, samples: Floats, end: float) -> None:
        self._samples = samples.astype(np.float32)
        self._end = end
        self.now = 0.0

    def busy_until(self) -> float:
        """The end of the reply."""
        return self._end

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """The samples before now."""
        at = round(self.now * SAMPLE_RATE)
        length = round(seconds * SAMPLE_RATE)
        padded = np.pad(self._samples, (length, 0))
        return padded[at : at + length], self.now


def speech(path: Path) -> Floats:
    """The samples of a recording."""
    return np.concatenate(list(read_blocks(path))).astype(float)


def power(samples: Floats) -> float:
    loud = samples[np.abs(samples) > 0.1 * np.abs(samples).max()]
    return float(np.mean(loud**2))


def heard(recognizer: Recognizer, sound: Floats, played: Played | None) -> list[str]:
    """What is halted for or obeyed: with the half duplex, or by the plain recognizer."""
    samples = np.clip(np.rint(sound), -32768, 32767).astype(np.int16)
    texts = []
    duplex = HalfDuplex(recognizer, played, ("stop",)) if played else None
    stream = recognizer.stream("")
    for at in range(0, len(samples) - BLOCK, BLOCK):
        block = samples[at : at + BLOCK]
        if duplex and played:
            played.now = (at + BLOCK) / SAMPLE_RATE
            events = duplex.feed(block, played.now)
        else:
            events = stream.feed(block)
        texts += [e.text for e in events if counts(e)]
    return texts


def counts(event: Utterance | Partial) -> bool:
    return isinstance(event, Partial) or (event.accepted and not event.ignored)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("manifests", nargs="+", type=Path)
    parser.add_argument("--most", type=int, default=60)
    arguments = parser.parse_args()
    clips = [c for c in read_manifests(arguments.manifests) if c.text == "stop"]
    clips = [c for c in clips if c.kind == "command" and c.condition != "robotic"]
    clips = random.Random(0).sample(clips, min(len(clips), arguments.most))
    recognizer = Recognizer(find_language(None), Recognition())
    rng = np.random.default_rng(0)
    found: dict[str, list[bool]] = {}
    for number, clip in enumerate(clips):
        reply = speech(cached_speech(default_commands().replies[number % 2], "kal_diphone"))
        played = np.concatenate([np.zeros(24000), reply, np.zeros(24000)])
        echo = np.convolve(played, room_response(rng))[: len(played)]
        echo = np.concatenate([np.zeros(round(LATE * SAMPLE_RATE)), echo])[: len(played)]
        said = speech(clip.path)
        echo *= np.sqrt(power(said) * 10 ** (LOUDER / 10) / power(echo))
        top = np.abs(echo).max() / DISTORTION / 3
        echo = np.tanh(echo / top) * top
        echo += rng.normal(0, 8, len(echo))
        at = 24000 + int(rng.uniform(0, 1) * max(1, len(reply) - len(said)))
        both = echo.copy()
        said = said[: len(both) - at]
        both[at : at + len(said)] += said

        def loudspeaker(played: Floats = played, end: int = 24000 + len(reply)) -> Played:
            return Played(played / 32768, end / SAMPLE_RATE + LATE)

        for name, texts in (
            ("stop alone", heard(recognizer, both - echo + rng.normal(0, 8, len(echo)), None)),
            ("stop in the reply, as it is", heard(recognizer, both, None)),
            ("stop in the reply, subtracted", heard(recognizer, both, loudspeaker())),
            ("the reply alone, as it is", heard(recognizer, echo, None)),
            ("the reply alone, subtracted", heard(recognizer, echo, loudspeaker())),
        ):
            found.setdefault(name, []).append("stop" in texts)
    print(f"{machine()}; {len(clips)} clips\n")
    for name, values in found.items():
        print(f"{name:32} stop heard in {np.mean(values):.3f}")


if __name__ == "__main__":
    main()
