"""From a stream of audio to utterances, as early as each can be told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from fcntl import LOCK_SH
from itertools import pairwise
from typing import NamedTuple

import numpy.typing as npt
from msgspec.structs import replace

from voz.audio import Samples
from voz.audio.capture.arrays import to_samples
from voz.audio.endpointing.segment import Segment, belong_together, feed_all
from voz.audio.endpointing.segmenter import Segmenter, VoiceFlags
from voz.events import Partial, Utterance
from voz.language.generated.file_checks import lock_folder
from voz.language.generated.language_files import LanguageFiles
from voz.language.sentences.command_set import Commands
from voz.recognition.confidence import Context
from voz.recognition.confidence_model import Model
from voz.recognition.interpreter import Interpreter
from voz.recognition.language import load_language
from voz.recognition.listener import Listener
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile
from voz.recognition.stream import Stream
from voz.records import check_type
from voz.settings import Recognition

MICROPHONE = "microphone"
"""The source of what a microphone hears."""

ARRAY = "array"
"""The source of what is heard in arrays of others."""


class Candidate(NamedTuple):
    """What the confidence of an utterance is computed from.

    Attributes:
        text: the sentence heard.
        values: its features.
        trust: how far the sound is to be trusted to be speech, 0 to 1.
        around: what is around it.
        start: where it begins in the recording, s.
        end: where it ends there, s.
    """

    text: str
    values: dict[str, float]
    trust: float
    around: Context
    start: float
    end: float


class Recognizer:
    """Finds the utterances in streams of audio; made once, used for many.

    Any thread may call it: the calls take turns, stretch of speech by stretch of speech, and each
    hears what it would hear alone. A signal handler that interrupts one of them may not, and gets
    a `RecognizerBusyError`.

    Attributes:
        files: the language files.
    """

    def __init__(
        self,
        language: LanguageFiles,
        settings: Recognition,
        profile: Profile | None = None,
        learning: bool = False,
    ) -> None:
        """Load the models.

        Args:
            language: the language files.
            settings: which search, how sure it must be, and how early.
            profile: what is known of the speaker and the microphone.
            learning: whether to learn more from each utterance, for those that follow.

        Raises:
            LanguageError: the language files cannot be used.
            ConfigError: the model of the confidence that the settings name cannot be used, or the
                profile was made with another acoustic model, or the settings are something else.
        """
        check_type(Recognition, settings, "settings")
        self.files = language
        self._settings = settings
        self._profile = profile or Profile()
        self._learning = learning
        self._interpreter = self._load()
        self._early = settings.early_decision

    def _load(self) -> Interpreter:
        with lock_folder(self.files.folder, LOCK_SH):  # all of one `voz build-lm`
            language = load_language(self.files)
            return Interpreter(language, self._settings, self._profile, self._learning)

    def reload(self, check: Callable[[Commands], None] = lambda _: None) -> None:
        """Read the language files again, for the streams that begin from now on.

        Args:
            check: raises what speaks against the new commands; then the old ones stay.

        Raises:
            LanguageError: the files cannot be used; the old commands stay.
        """
        renewed = self._load()
        check(renewed.commands)
        renewed.learnt = self._interpreter.learnt
        self._interpreter = renewed
        renewed.rule.accept_by(self._settings)  # another thread may have set them meanwhile

    def accept_by(self, alarms: float) -> None:
        """Let there be so many false alarms in an hour of talk, from the next decision on.

        Any thread may ask for it, also while a stream is followed.

        Raises:
            ConfigError: it is out of the range that `false_alarms_per_hour` has.
        """
        self._settings = replace(self._settings, false_alarms_per_hour=alarms)
        self._interpreter.rule.accept_by(self._settings)

    @property
    def model(self) -> Model:
        """What the confidence is computed by: the ears that there are."""
        return self._interpreter.model

    @property
    def commands(self) -> Commands:
        """What may be said."""
        return self._interpreter.commands

    def needed(self, text: str) -> float | None:
        """How sure a command must be to be accepted, 0 to 1; None if the text is none."""
        return self._interpreter.rule.threshold(text)

    @property
    def learnt(self) -> StartVector:
        """What is known of the microphone and the speaker; it changes only while learning."""
        return self._interpreter.learnt

    def stream(
        self, source: str, spotting: bool = True, voices: VoiceFlags | None = None
    ) -> Stream:
        """Begin to listen to a stream, as if there were no other.

        Args:
            source: its name, for utterances.
            spotting: whether a possible `stop` is told before the sound around it pauses.
            voices: tells in which frames a voice may be, where that is known already.
        """
        return Stream(self._interpreter, source, self._early, spotting, voices)

    def listen(self, rate: float | None = None) -> Listener:
        """Begin to listen to a stream of arrays.

        Args:
            rate: of the arrays, Hz; must be given.

        Raises:
            AudioError: no rate is given, or there is no speech in sound of that rate.
        """
        return Listener(self.stream(ARRAY), rate)

    def decode(self, array: npt.ArrayLike, rate: float | None = None) -> list[Utterance]:
        """Recognize a whole recording in an array.

        Args:
            array: samples, or samples x channels: int16, or floats from -1 to 1.
            rate: of the samples, Hz; must be given.

        Returns:
            Each stretch of speech in it, in the order of time.

        Raises:
            AudioError: no rate is given, or the array holds something else.
        """
        return list(self.utterances([to_samples(array, rate)], ARRAY))

    def utterances(self, blocks: Iterable[Samples], source: str) -> Iterator[Utterance]:
        """Recognize one recording; unless it is learning, as if there were no other.

        Args:
            blocks: its samples, 16 kHz, in blocks of any size.
            source: its name for the utterances.

        Yields:
            Each stretch of speech as soon as it can be told; times are within the recording.

        Raises:
            AudioError: the blocks end in one; what was heard up to there is yielded first.
        """
        stream = self.stream(source, spotting=False)
        return (e for e in feed_all(stream, blocks) if isinstance(e, Utterance))

    def events(self, blocks: Iterable[Samples], source: str) -> Iterator[Utterance | Partial]:
        """The same, with what is likely in between, before it is settled."""
        return feed_all(self.stream(source), blocks)

    def candidates(self, blocks: Iterable[Samples]) -> Iterator[Candidate]:
        """Find what the confidence is computed from, for those who fit it.

        Args:
            blocks: a recording, as for `utterances`.

        Yields:
            What is known of each utterance that may be a command.
        """
        sounds = feed_all(Segmenter(longest=self._interpreter.longest), blocks)
        found = [sound for sound in sounds if isinstance(sound, Segment)]
        after = [belong_together(one, other) for one, other in pairwise(found)]
        for number, segment in enumerate(found):
            heard = self._interpreter.understand(segment)
            if heard.values:
                among = segment.amid or any(after[max(0, number - 1) : number + 1])
                around = Context.SPEECH if among else Context.QUIET
                values, trust = dict(heard.values), heard.trust
                yield Candidate(heard.text, values, trust, around, segment.start, segment.end)
