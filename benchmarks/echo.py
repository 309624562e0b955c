"""Whether `stop` is heard while the robot speaks, and nothing else is; and what a page hears then.

Run `python benchmarks/echo.py MANIFEST... [--most N]`. Each `stop` of the manifests is put
somewhere into a reply of the robot's that is heard in a room, 10 dB louder than the speaker, a
little distorted as by a small loudspeaker, and 60 ms late. Then other commands are said from the
beginning of a reply until some time after it, which a page plays 0.3 s late, so loud as it says.
"""

from __future__ import annotations

import argparse
import random
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
from machine import machine

from voz.apps.evaluation.noise import room_response
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.apps.web.page_playback import PLAYBACK_DELAY
from voz.audio import SAMPLE_RATE
from voz.audio.capture.sound_files import read_blocks
from voz.config import default_commands
from voz.events import Partial, Utterance
from voz.hearing.half_duplex import HalfDuplex
from voz.language.generated.language_files import find_language
from voz.recognition.recognizer import Recognizer, open_stream
from voz.settings import Recognition
from voz.speech.speech_cache import cached_speech

LOUDER = 10.0
"""The reply over the speaker, dB."""

LATE = 0.06
"""The sound system's delay, s."""

PAGE_LATE = 0.3
"""A page's delay: it begins to play when the robot has answered, on a wireless loudspeaker, s."""

PAGE_LOUDER = (None, -10.0, 0.0, 10.0)
"""The reply of a page over the speaker, dB; None for headphones."""

OFFSETS = np.arange(0.0, 3.1, 0.5)
"""Command after the beginning of the reply, s."""

DISTORTION = 0.15
BLOCK = 480

Floats = npt.NDArray[np.float64]


class Played:
    """A loudspeaker whose time is that of the samples."""

    def __init__(self, samples: Floats, end: float, text: str | None = None) -> None:
        self._samples = samples.astype(np.float32)
        self._end = end
        self._text = text
        self.now = 0.0

    def busy_until(self) -> float:
        """The end of the reply."""
        return self._end

    def replies(self) -> str | None:
        """The words of the reply, if commands count that have none of them."""
        return self._text

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
    stream = open_stream(recognizer, "")
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


def echo_of(played: Floats, late: float, power_of_echo: float, rng: np.random.Generator) -> Floats:
    """What a microphone hears of a reply by a small loudspeaker in a room."""
    echo = np.convolve(played, room_response(rng))[: len(played)]
    echo = np.concatenate([np.zeros(round(late * SAMPLE_RATE)), echo])[: len(played)]
    echo *= np.sqrt(power_of_echo / power(echo))
    top = np.abs(echo).max() / DISTORTION / 3
    return np.asarray(np.tanh(echo / top) * top)


def print_page(recognizer: Recognizer, clips: list[Clip], rng: np.random.Generator) -> None:
    """Print which commands are heard while a page replies, and what replies alone raise."""
    begin = SAMPLE_RATE * 3 // 2
    print("\nA command that begins so long after the reply of a page, heard by its microphone:")
    print("| reply over the speaker | known | " + " | ".join(f"{o:g} s" for o in OFFSETS), end="")
    print(" | replies alone obeyed |")
    print("|---" * (len(OFFSETS) + 3) + "|")
    for louder in PAGE_LOUDER:
        found: dict[bool, list[bool]] = {False: [], True: []}
        raised = {False: 0, True: 0}
        for number, clip in enumerate(clips):
            text = default_commands().replies[number % 2]
            reply = speech(cached_speech(text, "kal_diphone"))
            played = np.pad(reply, (begin, 5 * SAMPLE_RATE))
            said = speech(clip.path)
            echo = rng.normal(0, 8, len(played))
            if louder is not None:
                loudness = power(said) * 10 ** (louder / 10)
                echo += echo_of(played, PAGE_LATE, loudness, rng)
            end = (begin + len(reply)) / SAMPLE_RATE + PLAYBACK_DELAY
            at = begin + round(OFFSETS[number % len(OFFSETS)] * SAMPLE_RATE)
            both = echo + np.pad(said, (at, max(0, len(echo) - at - len(said))))[: len(echo)]
            for known in (False, True):
                loudspeaker = partial(Played, played / 32768, end, text if known else None)
                found[known].append(clip.text in heard(recognizer, both, loudspeaker()))
                raised[known] += bool(heard(recognizer, echo, loudspeaker()))
        for known, values in found.items():
            shares = [np.mean(values[n :: len(OFFSETS)]) for n in range(len(OFFSETS))]
            cells = " | ".join(f"{share:.2f}" for share in shares)
            name = "headphones" if louder is None else f"{louder:+g} dB"
            print(f"| {name} | {'yes' if known else 'no'} | {cells} | ", end="")
            print(f"{raised[known]} of {len(clips)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("manifests", nargs="+", type=Path)
    parser.add_argument("--most", type=int, default=60)
    arguments = parser.parse_args()
    every = [c for c in read_manifests(arguments.manifests) if c.kind == "command"]
    every = [c for c in every if c.condition != "robotic"]
    clips = [c for c in every if c.text == "stop"]
    clips = random.Random(0).sample(clips, min(len(clips), arguments.most))
    recognizer = Recognizer(find_language(None), Recognition())
    rng = np.random.default_rng(0)
    print(f"{machine()}; {len(clips)} clips\n")
    if clips:
        print_stops(recognizer, clips, rng)
    others = [c for c in every if "stop" not in c.text and c.text != "start speech"]
    others = random.Random(0).sample(others, min(len(others), arguments.most))
    print_page(recognizer, others, rng)


def print_stops(recognizer: Recognizer, clips: list[Clip], rng: np.random.Generator) -> None:
    """Print whether `stop` is heard while the robot's own loudspeaker replies."""
    found: dict[str, list[bool]] = {}
    for number, clip in enumerate(clips):
        reply = speech(cached_speech(default_commands().replies[number % 2], "kal_diphone"))
        played = np.concatenate([np.zeros(24000), reply, np.zeros(24000)])
        said = speech(clip.path)
        echo = echo_of(played, LATE, power(said) * 10 ** (LOUDER / 10), rng)
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
    for name, values in found.items():
        print(f"{name:32} stop heard in {np.mean(values):.3f}")


if __name__ == "__main__":
    main()
