"""Listens to the microphone on a thread of its own, and reopens it after a loss."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeAlias

from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.microphone import open_microphone
from voz.audio.recording_level import FULL_SCALE_DB, MIN_DBFS
from voz.errors import AudioError, VozError
from voz.events import Partial, Utterance, shift_time
from voz.hearing.half_duplex import HalfDuplex, Playback
from voz.hearing.sound_watch import MUTED_AFTER_IN_MOTION, SilenceCheck, SoundWatch
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands
from voz.recognition.recognizer import MICROPHONE, Recognizer

NO_SOUND_TIMEOUT = 0.35
"""Without a block for this time the microphone is lost, s; with the beat, 0.5 s."""

MAX_LAG = 0.4
"""A larger delay of the recognition stops the robot, s: a command would come too late."""

RETRY_DELAYS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Before a lost microphone is opened again, s; the last one repeats."""

MICROPHONE_CLOSE_TIMEOUT = 1.0
"""A hanging sound server never closes it, s."""


class OpenMicrophone(Protocol):
    """An iterator over blocks of sound, 16 kHz, stream by stream; a sound card's has one stream.

    Attributes:
        name: of the device.
        alive: monotonic time of the last sign of life, s.
        arrived: monotonic arrival time of the block that was taken last, s.
        blocks_lost: number of dropped blocks, of `MICROPHONE_BLOCK_SECONDS` each.
        whole: whether the stream that ended is complete; else what is open in it is dropped.
        addressed: whether what is said is meant for the robot, as somebody holds a button to talk.
    """

    name: str
    alive: float
    arrived: float
    blocks_lost: int
    whole: bool
    addressed: bool

    def __iter__(self) -> Iterator[Samples]:
        """Return itself."""

    def __next__(self) -> Samples:
        """Return a block; raises AudioError on failure, StopIteration at a stream's end."""


MicrophoneOpener: TypeAlias = Callable[[], AbstractContextManager[OpenMicrophone]]


@dataclass(frozen=True)
class SoundSource:
    """Where sound comes from.

    Attributes:
        open: opens the microphone for a `with` block.
        source: the `source` of the utterances.
        playback: the robot's own sound; None if the microphone cannot hear it.
    """

    open: MicrophoneOpener
    source: str = MICROPHONE
    playback: Playback | None = None


class SoundRecorder(Protocol):
    """Records sound and the utterances in it."""

    @property
    def note(self) -> str:
        """A text that the user always sees; empty if nothing is recorded any more."""

    def feed(self, block: Samples) -> None:
        """Take the next samples, 16 kHz, without waiting."""

    def mark(self, utterance: Utterance, begun: float) -> None:
        """Keep an utterance of the stream that began at `begun`, s of the run."""

    def end_stream(self) -> None:
        """End the stream; what follows is another one."""


def sound_card(device: str | None) -> SoundSource:
    """Return a microphone of this computer by its number or a part of its name."""
    return SoundSource(partial(open_microphone, device))


class Hearing:
    """Listens in a `with` block, and puts what is said into an inbox.

    Attributes:
        peak: highest sample of the last block, 0 to 1.
        background: level of the room, dBFS.
        deaf: whether the robot speaks, so that only `never_missed` commands count.
        device: name of the microphone.
        source: the `source` of the utterances.
    """

    def __init__(
        self,
        recognizer: Recognizer,
        sound: SoundSource,
        inbox: Inbox,
        clock: Callable[[], float],
        recorder: SoundRecorder | None = None,
        *,
        never_missed: Collection[str] = (),
    ) -> None:
        """Prepare to listen.

        Args:
            recognizer: understands the sound.
            sound: where it comes from.
            inbox: where events go.
            clock: the time of the run, s.
            recorder: records the sound.
            never_missed: the commands that count while the robot speaks.
        """
        self.peak, self.background = 0.0, MIN_DBFS
        self.deaf, self.device = False, ""
        self.source = sound.source
        self._recognizer = recognizer
        self._open = sound.open
        self._inbox = inbox
        self._clock = clock
        self._playback = sound.playback
        self._never_missed = never_missed
        self._recorder = recorder
        self._microphone: OpenMicrophone | None = None
        self._silence = SilenceCheck()
        self._zeros = 0.0  # how long it has given only zeros, s
        self._problem: str | None = None
        self._failures = 0  # consecutive failures to listen
        self._busy_since: float | None = None
        self._closing = threading.Event()
        self._opened = threading.Event()
        self._thread = threading.Thread(target=self._work, name="voz-hearing", daemon=True)

    def __enter__(self) -> Hearing:
        """Start to listen; raises AudioError if there is no such microphone."""
        self._thread.start()
        self._opened.wait()
        if self._microphone is None:
            self._closing.set()
            raise AudioError(self._problem)
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.set()
        self._thread.join(MICROPHONE_CLOSE_TIMEOUT)

    @property
    def commands(self) -> Commands:
        """The list of commands."""
        return self._recognizer.commands

    def expect(self, answers: tuple[str, ...]) -> None:
        """Understand these answers too from now on; none: only commands."""
        self._recognizer.expect(answers)

    def trouble(self, moving: bool) -> str | None:
        """Return why nothing is heard now; a muted microphone counts while the robot moves."""
        microphone, now = self._microphone, time.monotonic()
        if self._problem or microphone is None:
            return self._problem
        quiet = now - microphone.alive
        if quiet > NO_SOUND_TIMEOUT:
            return "no sound comes from the microphone"
        busy_since = self._busy_since
        if busy_since is not None and now - busy_since > MAX_LAG:
            return "the computer is too slow to follow"
        if not self._thread.is_alive():
            return "the microphone thread died"
        # Also if it was muted first, and then gave nothing.
        silent = self._zeros > 0 and self._zeros + quiet >= MUTED_AFTER_IN_MOTION
        return self._silence.trouble(silent, moving)

    @property
    def only_silence(self) -> bool:
        """Whether the microphone gives only zeros, as a muted one does."""
        return self._zeros >= MUTED_AFTER_IN_MOTION

    def _work(self) -> None:
        while not self._closing.is_set():
            try:
                with self._open() as microphone:
                    self._begin(microphone)
                    while not self._closing.is_set():
                        self._listen(microphone)
            except VozError as error:
                self._note_loss(str(error))
            except BaseException as error:  # whatever it is, the robot must not drive on unheard
                self._note_loss(f"the recognizer fails ({error!r})")
            if self._recorder:
                self._recorder.end_stream()
            self._opened.set()
            self._closing.wait(RETRY_DELAYS[min(self._failures, len(RETRY_DELAYS) - 1)])
            self._failures += 1

    def _begin(self, microphone: OpenMicrophone) -> None:
        self.device = microphone.name
        microphone.alive = time.monotonic()  # opening may have taken long
        self._microphone = microphone
        self._opened.set()

    def _note_loss(self, problem: str) -> None:
        self.peak = 0.0
        self.deaf = False
        self._busy_since = None
        self._problem = problem

    def _listen(self, microphone: OpenMicrophone) -> None:
        """Follow one stream to its end, or until the commands change."""
        commands = self._recognizer.commands
        duplex = HalfDuplex(self._recognizer, self._playback, self._never_missed, self.source)
        watch = SoundWatch(self._inbox, self._clock)
        fed = 0
        for block in microphone:
            if self._closing.is_set():
                return
            self._busy_since = microphone.arrived
            fed += len(block)
            self.peak = watch.check(block, microphone.blocks_lost)
            self._zeros = watch.zeros
            if self._recorder:
                self._recorder.feed(block)
            self._send(duplex.feed(block, microphone.arrived), microphone, fed)
            self.deaf = duplex.deaf
            self.background = duplex.background - FULL_SCALE_DB
            self._problem, self._failures = None, 0
            if time.monotonic() - microphone.arrived < NO_SOUND_TIMEOUT:  # else more sound waits
                self._busy_since = None
            if self._recognizer.commands is not commands:
                break
        if microphone.whole:
            self._send(duplex.finish(), microphone, fed)
        self._busy_since, self._zeros = None, 0.0
        if self._recorder:
            self._recorder.end_stream()

    def _send(
        self, events: Iterator[Utterance | Partial], microphone: OpenMicrophone, fed: int
    ) -> None:
        """Put events of a stream, of which so many samples were fed, into the inbox."""
        begun = self._clock() - (time.monotonic() - microphone.arrived) - fed / SAMPLE_RATE
        needs_no_name = bool(self._recognizer.name) and microphone.addressed
        for event in events:
            told = self._to_run_time(event, begun)
            if needs_no_name and isinstance(told, Utterance):
                told = replace(told, named=True)
            self._inbox.put(told)
            if self._recorder and isinstance(told, Utterance):
                self._recorder.mark(told, begun)

    def _to_run_time(self, event: Utterance | Partial, begun: float) -> Utterance | Partial:
        """Convert the times of a stream to those of the run."""
        now = self._clock()
        moved = replace(shift_time(event, begun), t=round(now, 3))
        if isinstance(event, Utterance) and event.latency is not None:
            spoken_until = begun + event.t - event.latency
            return replace(moved, latency=round(now - spoken_until, 3))
        return moved
