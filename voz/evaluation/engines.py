"""What recognises: voz itself, or something else to compare it with.

An engine takes the samples of a whole recording and gives what it heard; to score another one,
write such a function and give it a name in `load_engine`, or call a program by `command:`.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

from voz.audio import SAMPLE_RATE, Samples
from voz.config import Recognition
from voz.errors import AudioError, ConfigError
from voz.evaluation.results import Understood
from voz.language.files import LanguageFiles, read_sentences

Engine: TypeAlias = Callable[[Samples], list[Understood]]
"""Samples of a recording, 16 kHz, to utterances in their order.

Raises AudioError, one line with the reason, if it cannot make anything of this recording.
"""

PROGRAM = "command:"
"""Begins the name of an engine that is a program."""

PROGRAM_SECONDS = 60.0
"""A program that takes longer for one recording hangs."""


@dataclass(frozen=True)
class EngineChoice:
    """An engine that is not loaded yet: what a process is told to load it by.

    Attributes:
        name: `voz`, `plain-pocketsphinx` or `command:PROGRAM ARGUMENTS`.
        language: the language files.
        settings: of voz's own recogniser.
    """

    name: str
    language: LanguageFiles
    settings: Recognition


def load_engine(choice: EngineChoice) -> Engine:
    """Load the engine that was chosen.

    Raises:
        ConfigError: there is no such engine or program.
        LanguageError: the language files cannot be used.
    """
    if choice.name == "voz":
        return voz_engine(choice.language, choice.settings)
    if choice.name == "plain-pocketsphinx":
        return plain_pocketsphinx(choice.language)
    if choice.name.startswith(PROGRAM):
        commands = frozenset(read_sentences(choice.language))
        return program_engine(choice.name.removeprefix(PROGRAM), commands)
    raise ConfigError(
        f'there is no engine "{choice.name}"; use voz, plain-pocketsphinx or '
        f'"{PROGRAM}PROGRAM ARGUMENTS"'
    )


def voz_engine(language: LanguageFiles, settings: Recognition) -> Engine:
    """Load voz: it finds the speech, what was said in it, and how sure that is."""
    from voz.recognition.recognizer import Recognizer

    recognizer = Recognizer(language, settings)

    def recognise(samples: Samples) -> list[Understood]:
        return [
            Understood(heard.text, heard.confidence, heard.accepted)
            for heard in recognizer.utterances([samples], "clip")
        ]

    return recognise


def plain_pocketsphinx(language: LanguageFiles) -> Engine:
    """Load pocketsphinx with voz's grammar as its documentation shows it: what voz began from.

    It takes the whole recording for one utterance and is always sure.
    """
    from pocketsphinx import Decoder

    decoder = Decoder(
        jsgf=str(language.grammar), dict=str(language.dictionary), lm=None, loglevel="FATAL"
    )

    def recognise(samples: Samples) -> list[Understood]:
        decoder.start_utt()
        decoder.process_raw(samples.tobytes(), full_utt=True)
        decoder.end_utt()
        hypothesis = decoder.hyp()
        text = str(hypothesis.hypstr) if hypothesis else ""
        return [Understood(text, 1.0, accepted=True)] if text else []

    return recognise


def program_engine(command: str, commands: frozenset[str]) -> Engine:
    """Let any program recognise.

    Args:
        command: the program and its arguments, quoted as for a shell, though none runs it. The
            path of a WAV file, 16 kHz, mono, 16 bit, is added as the last argument; what the
            program writes to standard output is the transcript.
        commands: what is obeyed if it is the transcript, which may be in any case and with
            punctuation.

    Raises:
        ConfigError: there is no such program.
    """
    arguments = _arguments(command)

    def recognise(samples: Samples) -> list[Understood]:
        text = _words(_transcript(arguments, samples))
        return [Understood(text, 1.0, accepted=text in commands)] if text else []

    return recognise


def _arguments(command: str) -> list[str]:
    try:
        arguments = shlex.split(command)
    except ValueError as error:
        raise ConfigError(f'"{PROGRAM}{command}": {error}; close all quotes') from None
    if not arguments:
        raise ConfigError(f'"{PROGRAM}" names no program; write "{PROGRAM}PROGRAM ARGUMENTS"')
    if shutil.which(arguments[0]) is None:
        raise ConfigError(f"{arguments[0]}: there is no such program; name one that can be run")
    return arguments


def _transcript(arguments: list[str], samples: Samples) -> str:
    """Run a program on a recording; give what it writes to standard output."""
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
                timeout=PROGRAM_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise AudioError(f"{name}: was not done after {PROGRAM_SECONDS:g} s") from None
        except OSError as error:
            raise AudioError(f"{name}: cannot be run ({error.strerror})") from None
    if done.returncode != 0:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise AudioError(f"{name}: failed with exit code {done.returncode}{_because(last)}")
    return done.stdout.decode(errors="replace")


def _because(lines: list[str]) -> str:
    return f" ({lines[0]})" if lines else ""


def _words(transcript: str) -> str:
    """The words of a transcript as commands are written: lower case, no punctuation."""
    return " ".join(re.findall(r"[^\W_]+(?:'[^\W_]+)*", transcript.lower()))
