"""What recognizes: voz itself, or something else to compare it with.

An engine takes the samples of a whole recording and gives what it heard; to score another one,
write such a function and give it a name in `load_engine`, or call a program by `command:`.
"""

from __future__ import annotations

import math
import re
import shlex
import shutil
import subprocess
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from msgspec.structs import replace

from voz.apps.evaluation.results import Understood
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError, ConfigError
from voz.language.language_files import LanguageFiles, check_files, read_commands
from voz.settings import Recognition

Engine: TypeAlias = Callable[[Samples], list[Understood]]
"""Samples of a recording, 16 kHz, to utterances in their order.

Raises AudioError, one line with the reason, if it cannot make anything of this recording.
"""

PHONE_LOOP_THRESHOLD = -21.2
"""Log-likelihood, base 1.0001, per frame of 10 ms; refuses 5 % of right synthetic commands."""

LONGEST_SINGLE_COMMAND = 3.0
"""A recording of one command is shorter, s; a longer one may hold several utterances."""

PROGRAM_PREFIX = "command:"
"""Prefix of the name of an engine that is a program."""

PROGRAM_TIMEOUT = 60.0
"""A program that takes longer for one recording has failed, s."""


@dataclass(frozen=True)
class EngineChoice:
    """An engine that is not loaded yet: what a process is told to load it by."""

    name: str  # one of `ENGINES` or `command:PROGRAM ARGUMENTS`
    language: LanguageFiles
    settings: Recognition  # of voz's own recognizer


def load_engine(choice: EngineChoice) -> Engine:
    """Load the engine that was chosen; raises VozError."""
    if choice.name in ENGINES:
        return ENGINES[choice.name](choice.language, choice.settings)
    if choice.name.startswith(PROGRAM_PREFIX):
        commands = read_commands(choice.language)
        return program_engine(choice.name.removeprefix(PROGRAM_PREFIX), commands)
    raise ConfigError(
        f'there is no engine "{choice.name}"; use {", ".join(ENGINES)} '
        f'or "{PROGRAM_PREFIX}PROGRAM ARGUMENTS"'
    )


def voz_engine(language: LanguageFiles, settings: Recognition) -> Engine:
    """Load voz itself."""
    from voz.recognition.engine import RecognitionEngine

    recognizer = RecognitionEngine(language, settings)

    def recognize(samples: Samples) -> list[Understood]:
        return [
            Understood(heard.text, heard.confidence, heard.accepted, heard.start, heard.end)
            for heard in recognizer.utterances([samples], "clip")
        ]

    return recognize


def without_network(language: LanguageFiles, settings: Recognition) -> Engine:
    """Load voz without its phoneme network."""
    return voz_engine(language, replace(settings, use_network=False))


def plain_pocketsphinx(language: LanguageFiles, _settings: Recognition) -> Engine:
    """Load pocketsphinx as its documentation shows it: one utterance, always sure."""
    from pocketsphinx import Decoder

    check_files(language)
    decoder = Decoder(
        jsgf=str(language.grammar), dict=str(language.dictionary), lm=None, loglevel="FATAL"
    )

    def recognize(samples: Samples) -> list[Understood]:
        decoder.start_utt()
        decoder.process_raw(samples.tobytes(), full_utt=True)
        decoder.end_utt()
        hypothesis = decoder.hyp()
        text = str(hypothesis.hypstr) if hypothesis else ""
        return _single_utterance(samples, text, accepted=True)

    return recognize


def pocketsphinx_with_phone_loop(language: LanguageFiles, _settings: Recognition) -> Engine:
    """Load pocketsphinx with a free loop of phones, its own way to refuse other speech.

    A command is accepted if it explains the speech nearly as well as any phones would. Longer
    recordings are cut by pocketsphinx's end-pointer with its own settings.
    """
    from pocketsphinx import Decoder, get_model_path

    check_files(language)
    # Their scores are comparable only if both score all states of each frame.
    model = {"dict": str(language.dictionary), "lm": None, "loglevel": "FATAL", "compallsen": True}
    grammar = Decoder(jsgf=str(language.grammar), bestpath=False, **model)
    phones = Decoder(allphone=get_model_path("en-us/en-us-phone.lm.bin"), lw=2.0, **model)

    def recognize(samples: Samples) -> list[Understood]:
        heard = []
        for data, start, end in _parts(samples):
            text, score = _decode(grammar, data)
            if text:
                accepted = _score_per_frame(score, phones, data) >= PHONE_LOOP_THRESHOLD
                heard.append(Understood(text, float(accepted), accepted, start, end))
        return heard

    return recognize


ENGINES: dict[str, Callable[[LanguageFiles, Recognition], Engine]] = {
    "voz": voz_engine,
    "without-network": without_network,
    "plain-pocketsphinx": plain_pocketsphinx,
    "pocketsphinx-phone-loop": pocketsphinx_with_phone_loop,
}


def _single_utterance(samples: Samples, text: str, accepted: bool) -> list[Understood]:
    return [Understood(text, 1.0, accepted, 0.0, len(samples) / SAMPLE_RATE)] if text else []


def _parts(samples: Samples) -> Iterator[tuple[bytes, float, float]]:
    """The utterances of a recording, with their start and end, s; one if it is short."""
    from pocketsphinx import Endpointer

    data = samples.tobytes()
    if len(samples) <= LONGEST_SINGLE_COMMAND * SAMPLE_RATE:
        yield data, 0.0, len(samples) / SAMPLE_RATE
        return
    endpointer = Endpointer()
    size = endpointer.frame_bytes
    said: list[bytes] = []
    for start in range(0, len(data), size):
        frame = data[start : start + size]
        last = start + size >= len(data)
        if speech := endpointer.end_stream(frame) if last else endpointer.process(frame):
            said.append(speech)
        if said and not endpointer.in_speech:
            yield b"".join(said), endpointer.speech_start, endpointer.speech_end
            said.clear()


def _decode(decoder: Any, data: bytes) -> tuple[str, float]:
    """Decode an utterance as if it were alone: its words and their log-likelihood."""
    decoder.reinit_feat()
    decoder.start_utt()
    decoder.process_raw(data, full_utt=True)
    decoder.end_utt()
    hypothesis = decoder.hyp()
    if hypothesis is None:
        return "", -math.inf
    return str(hypothesis.hypstr), math.log(hypothesis.score, 1.0001)


def _score_per_frame(score: float, phones: Any, data: bytes) -> float:
    """Return how much better a score is than that of the phone loop, per frame of speech."""
    _, against = _decode(phones, data)
    spoken = [s for s in phones.seg() or () if s.word != "SIL" and not s.word.startswith("+")]
    frames = sum(segment.end_frame - segment.start_frame + 1 for segment in spoken)
    # Without phones there is no command.
    return (score - against) / frames if frames else -math.inf


def program_engine(command: str, commands: Collection[str]) -> Engine:
    """Let any program recognize.

    Args:
        command: the program and its arguments, quoted as for a shell, though none runs it. The
            path of a WAV file, 16 kHz, mono, 16 bit, is added as the last argument; the
            transcript is what the program writes to standard output.
        commands: the transcripts that are obeyed, in any case and with any punctuation.

    Raises:
        ConfigError: there is no such program.
    """
    arguments = _arguments(command)

    def recognize(samples: Samples) -> list[Understood]:
        text = normalized_words(_transcript(arguments, samples))
        return _single_utterance(samples, text, accepted=text in commands)

    return recognize


def _arguments(command: str) -> list[str]:
    try:
        arguments = shlex.split(command)
    except ValueError as error:
        raise ConfigError(f'"{PROGRAM_PREFIX}{command}": {error}; close all quotes') from None
    if not arguments:
        raise ConfigError(
            f'"{PROGRAM_PREFIX}" names no program; write "{PROGRAM_PREFIX}PROGRAM ARGUMENTS"'
        )
    if shutil.which(arguments[0]) is None:
        raise ConfigError(f"{arguments[0]}: there is no such program; name one that can be run")
    return arguments


def _transcript(arguments: list[str], samples: Samples) -> str:
    """Run a program on a recording; returns its standard output."""
    import soundfile

    name = arguments[0]
    with TemporaryDirectory(prefix="voz-eval-") as folder:
        wav = Path(folder) / "clip.wav"
        soundfile.write(wav, samples, SAMPLE_RATE, subtype="PCM_16")
        try:
            done = subprocess.run(
                [*arguments, str(wav)],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=PROGRAM_TIMEOUT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise AudioError(f"{name}: was not done after {PROGRAM_TIMEOUT:g} s") from None
        except OSError as error:
            raise AudioError(f"{name}: cannot be run ({error.strerror})") from None
    if done.returncode != 0:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        reason = f" ({last[0]})" if last else ""
        raise AudioError(f"{name}: failed with exit code {done.returncode}{reason}")
    return done.stdout.decode(errors="replace")


def normalized_words(transcript: str) -> str:
    """Return the words of a transcript as commands are written: lower case, no punctuation."""
    return " ".join(re.findall(r"[^\W_]+(?:'[^\W_]+)*", transcript.lower()))
