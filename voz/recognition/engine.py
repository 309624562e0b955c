"""What runs and apps use of recognition: utterances in streams of samples, 16 kHz."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fcntl import LOCK_SH
from functools import partial

import numpy as np
from msgspec.structs import replace

from voz.audio import Samples
from voz.audio.segment import Segment, feed_all
from voz.audio.segmenter import Segmenter
from voz.errors import AudioError
from voz.events import Partial, Utterance
from voz.language.language_files import LanguageFiles, lock_folder
from voz.language.sentences.command_set import Commands
from voz.recognition.confidence import Context, Model
from voz.recognition.interpreter import NO_DETAILS, Details, Interpreter
from voz.recognition.language import load_language, with_more_words
from voz.recognition.profiles import Profile
from voz.recognition.spotting import PlaybackSpotter
from voz.recognition.stream import Stream
from voz.records import PublicNames, check_callable, check_iterable, check_type
from voz.settings import Ask, Recognition

MICROPHONE = "microphone"


@dataclass(frozen=True)
class Candidate:
    """The input of the confidence of an utterance."""

    text: str  # the best sentence
    features: dict[str, float]
    speech_probability: float  # how surely the sound is speech, 0 to 1
    context: Context
    start: float  # s in the recording
    end: float  # s in the recording


MAX_NAMED = 20
"""So many commands stand in the representation of an engine."""


class RecognitionEngine(PublicNames):
    """Finds the utterances in streams of samples; made once, used for many.

    Any thread may call it; the calls take turns and do not affect each other. A signal handler that
    interrupts a call gets a `RecognizerBusyError`.

    Attributes:
        files: the language files.
    """

    def __init__(
        self,
        language: LanguageFiles,
        settings: Recognition,
        profile: Profile | None = None,
    ) -> None:
        """Load the models.

        Args:
            language: the language files.
            settings: which search, which thresholds, and how early to decide.
            profile: of the speaker and the microphone.

        Raises:
            LanguageError: the language files cannot be used.
            ConfigError: the settings or a file that they name cannot be used, or the profile was
                made with another acoustic model.
        """
        check_type(LanguageFiles, language, "language")
        check_type(Recognition, settings, "settings")
        check_type((Profile, type(None)), profile, "profile")
        self.files = language
        self._settings = settings
        self._profile = profile or Profile()
        self._interpreter = self._load()
        self._early = settings.early_decision

    def __repr__(self) -> str:
        """Name the commands, the first of many."""
        commands = self.commands
        listed = commands.can_be_listed
        texts = commands.listed[:MAX_NAMED] if listed else commands.sample(MAX_NAMED)
        more = f" and {len(commands) - len(texts):,} more" if len(commands) > len(texts) else ""
        return f"<{type(self).__name__}: {', '.join(texts)}{more}>"

    def _load(self) -> Interpreter:
        with lock_folder(self.files.folder, LOCK_SH):  # all of one `voz build-lm`
            language = with_more_words(load_language(self.files), self._settings)
            settings = _as_in_list(self._settings, language.commands)
            return Interpreter(language, settings, self._profile)

    def reload(self, check: Callable[[Commands], None] = lambda _: None) -> None:
        """Read the language files again, for the streams that begin from now on.

        Args:
            check: called with the new commands; if it raises, the old ones stay.

        Raises:
            LanguageError: the files cannot be used; the old commands stay.
        """
        check_callable(check, "check")
        renewed = self._load()
        check(renewed.commands)
        self._interpreter = renewed
        # Another thread may have set it meanwhile.
        renewed.rule.set_false_alarm_rate(self._settings)

    def set_false_alarm_rate(self, alarms: float) -> None:
        """Set the false alarms in an hour of talk, on any thread; ConfigError if out of range."""
        self._settings = replace(self._settings, false_alarms_per_hour=alarms)
        self._interpreter.rule.set_false_alarm_rate(self._settings)

    def expect(self, answers: tuple[str, ...]) -> None:
        """Understand these answers too from now on, on any thread; none: only commands."""
        self._interpreter.rule.answers = tuple(check_iterable(answers, "answers"))
        for answer in self._interpreter.rule.answers:
            check_type(str, answer, "answers")

    @property
    def name(self) -> str:
        """What the robot is called; empty if it has no name."""
        return self._settings.name

    @property
    def name_advice(self) -> str:
        """What would make the robot's name better; empty if it is good."""
        return self._interpreter.name_advice

    @property
    def ask(self) -> Ask:
        """What the robot may ask back."""
        return self._settings.ask

    @property
    def commands(self) -> Commands:
        """All commands."""
        return self._interpreter.commands

    def threshold_of(self, text: str) -> float | None:
        """The confidence that a command needs, 0 to 1; None if the text is no command."""
        check_type(str, text, "text")
        return self._interpreter.rule.threshold(text)

    def utterances(
        self, blocks: Iterable[Samples], source: str, details: Details = NO_DETAILS
    ) -> Iterator[Utterance]:
        """Recognize a recording, independently of others.

        Args:
            blocks: samples, 16 kHz, in blocks of any size.
            source: its name, for the utterances.
            details: what utterances have besides.

        Yields:
            Utterances, each as early as it can be decided; times are within the recording.

        Raises:
            AudioError: raised by the blocks; the utterances before it are yielded first.
        """
        _check_stream(source, details)
        blocks = _samples(check_iterable(blocks, "blocks"))
        stream = open_stream(self, source, spotting=False, details=details)
        return (e for e in feed_all(stream, blocks) if isinstance(e, Utterance))

    def events(
        self, blocks: Iterable[Samples], source: str, details: Details = NO_DETAILS
    ) -> Iterator[Utterance | Partial]:
        """The same as `utterances`, with partial hypotheses."""
        _check_stream(source, details)
        blocks = _samples(check_iterable(blocks, "blocks"))
        return feed_all(open_stream(self, source, details=details), blocks)


def _as_in_list(settings: Recognition, commands: Commands) -> Recognition:
    """Write `never_missed` with the capitals, spaces and accents of the list."""
    names = tuple(commands.find_name(name) or name for name in settings.never_missed)
    return replace(settings, never_missed=names)


def _check_stream(source: object, details: object) -> None:
    check_type(str, source, "source")
    check_type(Details, details, "details")


def _samples(blocks: Iterator[Samples]) -> Iterator[Samples]:
    """The blocks of a recording; raises AudioError for what is no array of 16 bits."""
    for block in blocks:
        if getattr(block, "dtype", None) != np.int16 or block.ndim != 1:
            raise AudioError("a block is no array of 16-bit samples; `decode` takes other arrays")
        yield block


def open_playback_spotter(recognizer: RecognitionEngine, source: str) -> PlaybackSpotter:
    """Begin to look for what must not be missed while the robot speaks."""
    interpreter = recognizer._interpreter
    return PlaybackSpotter(interpreter.spotter, partial(interpreter.spotted, source=source))


def open_stream(
    recognizer: RecognitionEngine,
    source: str,
    spotting: bool = True,
    details: Details = NO_DETAILS,
) -> Stream:
    """Begin an independent stream, whose utterances name the source.

    With `spotting` a possible `stop` is reported before the sound around it pauses.
    """
    interpreter, early = recognizer._interpreter, recognizer._early
    return Stream(interpreter, source, early, spotting, details)


def confidence_model(recognizer: RecognitionEngine) -> Model:
    """Return the model of the confidence."""
    return recognizer._interpreter.model


def candidates_in(recognizer: RecognitionEngine, blocks: Iterable[Samples]) -> Iterator[Candidate]:
    """Yield what may be commands in a recording, to fit the confidence."""
    interpreter = recognizer._interpreter
    sounds = feed_all(Segmenter(longest=interpreter.longest), blocks)
    found = [sound for sound in sounds if isinstance(sound, Segment)]
    for number, segment in enumerate(found):
        heard = interpreter.understand(segment)
        if heard.features:
            beside = [*found[max(0, number - 1) : number], *found[number + 1 : number + 2]]
            context = interpreter.context(segment, beside)
            yield Candidate(
                heard.text, dict(heard.features), heard.speech_probability, context,
                segment.start, segment.end,
            )  # fmt: skip
