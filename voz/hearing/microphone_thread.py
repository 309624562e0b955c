"""Listens to the microphone on a thread of its own, and reopens it after a loss."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeAlias

import numpy as np
from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.channels import OUT_OF_PHASE
from voz.audio.microphone import MICROPHONE_BLOCK_SECONDS, ONLY_SILENCE, open_microphone
from voz.audio.recording_level import FULL_SCALE_DB, MIN_DBFS
from voz.audio.segment import NO_SAMPLES
from voz.errors import AudioError, VozError
from voz.events import Notice, Partial, Utterance, shift_time
from voz.hearing.half_duplex import HalfDuplex, Playback
from voz.inbox import Inbox
from voz.recognition.engine import MICROPHONE, RecognitionEngine

MUTED_AFTER = 5.0
"""A microphone that gives only zeros for this time is muted, s; no room is so quiet."""

MUTED_AFTER_IN_MOTION = 0.35
"""The same while the robot moves, s; with the beat, 0.5 s."""

LOSS_WARNING_INTERVAL = 5.0
"""Between two warnings of lost sound, s."""

MUTE_WARNING = f"{ONLY_SILENCE}: is it muted? `voz devices --test` shows it"


PHASE_WARNING = f"microphone: {OUT_OF_PHASE}"


class SilenceCheck:
    """Whether a muted microphone stops the robot: once the robot moves, and from then on."""

    def __init__(self) -> None:
        self._matters = False

    def trouble(self, silent: bool, moving: bool) -> str | None:
        """Return what is wrong, if the microphone is silent and the robot moves or has moved."""
        self._matters = silent and (moving or self._matters)
        return ONLY_SILENCE if self._matters else None


class SoundWatch:
    """Warns of a muted microphone, and of lost sound."""

    def __init__(self, inbox: Inbox, clock: Callable[[], float]) -> None:
        """Start a stream; warnings go into `inbox` with the time of `clock`, s."""
        self._inbox = inbox
        self._clock = clock
        self._blocks_lost = 0
        self._loss_told = -LOSS_WARNING_INTERVAL  # when
        self.zeros = 0.0  # how long the microphone has given only zeros, s

    def check(self, block: Samples, blocks_lost: int) -> float:
        """Check a block, and the number of lost blocks so far; returns its peak, 0 to 1."""
        now = self._clock()
        if blocks_lost > self._blocks_lost and now - self._loss_told >= LOSS_WARNING_INTERVAL:
            seconds = (blocks_lost - self._blocks_lost) * MICROPHONE_BLOCK_SECONDS
            self._blocks_lost, self._loss_told = blocks_lost, now
            self._warn(f"{seconds:.2f} s of sound were lost: the computer is too slow")
        peak = float(np.abs(block).max(initial=0)) / 32768
        before = self.zeros
        self.zeros = 0.0 if peak else before + len(block) / SAMPLE_RATE
        if before < MUTED_AFTER <= self.zeros:
            self._warn(MUTE_WARNING)
        return peak

    def _warn(self, text: str) -> None:
        self._inbox.put(Notice(round(self._clock(), 3), text))


NO_SOUND_TIMEOUT = 0.35
"""Without a block for this time the microphone is lost, s; with the beat, 0.5 s."""

MAX_LAG = 0.4
"""A larger delay of the recognition stops the robot, s: a command would come too late."""

RETRY_DELAYS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Before a lost microphone is opened again, s; the last one repeats."""

MICROPHONE_CLOSE_TIMEOUT = 1.0
"""A hanging sound server never closes it, s."""


class OpenMicrophone(Protocol):
    """An iterator over blocks of sound, 16 kHz, stream by stream; a sound card's has one stream."""

    name: str  # of the device
    alive: float  # monotonic time of the last sign of life, s
    arrived: float  # monotonic arrival time of the block that was taken last, s
    blocks_lost: int  # number of dropped blocks, of `MICROPHONE_BLOCK_SECONDS` each
    complete: bool  # whether the stream that ended is complete; else what is open in it is dropped
    # Whether what is said is meant for the robot, as somebody holds a button to talk.
    addressed: bool

    @property
    def out_of_phase(self) -> bool:
        """Whether it has channels that would cancel each other."""

    def __iter__(self) -> Iterator[Samples]:
        """Return itself."""

    def __next__(self) -> Samples:
        """Return a block; raises AudioError on failure, StopIteration at a stream's end."""


MicrophoneOpener: TypeAlias = Callable[[], AbstractContextManager[OpenMicrophone]]


@dataclass(frozen=True)
class SoundSource:
    """Where sound comes from."""

    open: MicrophoneOpener  # opens the microphone for a `with` block
    source: str = MICROPHONE  # the `source` of the utterances
    playback: Playback | None = None  # the robot's own sound; None if the microphone cannot hear it


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
        speaking: whether the robot speaks, so that only `never_missed` commands count.
        device: name of the microphone.
        source: the `source` of the utterances.
    """

    def __init__(
        self,
        recognizer: RecognitionEngine,
        sound: SoundSource,
        inbox: Inbox,
        clock: Callable[[], float],
        recorder: SoundRecorder | None = None,
        *,
        never_missed: Collection[str] = (),
    ) -> None:
        """Prepare to listen; events go to the inbox, with times by the clock of the run, s.

        `never_missed` are the commands that count while the robot speaks.
        """
        self.peak, self.background = 0.0, MIN_DBFS
        self.speaking, self.device = False, ""
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
        self._out_of_phase = False  # whether that was told
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
        self.speaking = False
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
            if microphone.out_of_phase and not self._out_of_phase:
                self._out_of_phase = True
                self._inbox.put(Notice(round(self._clock(), 3), PHASE_WARNING))
            if self._recorder:
                self._recorder.feed(block)
            self._send(duplex.feed(block, microphone.arrived), microphone, fed)
            self.speaking = duplex.speaking
            self.background = duplex.background - FULL_SCALE_DB
            self._problem, self._failures = None, 0
            if time.monotonic() - microphone.arrived < NO_SOUND_TIMEOUT:  # else more sound waits
                self._busy_since = None
            if self._recognizer.commands is not commands:
                break
        if microphone.complete:
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


POLL_INTERVAL = 0.1
"""How often the thread that listens looks for its end, s."""


NO_MICROPHONE = "none"
"""The name of what stands in place of a microphone, where a robot has none."""


class NoMicrophone:
    """An `OpenMicrophone` that hears nothing, and is never lost."""

    name = NO_MICROPHONE
    blocks_lost = 0
    complete = addressed = out_of_phase = False

    def __init__(self) -> None:
        self.arrived = time.monotonic()

    @property
    def alive(self) -> float:
        """Now, on the monotonic clock, s."""
        return time.monotonic()

    @alive.setter
    def alive(self, when: float) -> None:
        pass

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        time.sleep(POLL_INTERVAL)
        self.arrived = time.monotonic()
        return NO_SAMPLES


def no_sound() -> SoundSource:
    """Return a source of no sound."""
    return SoundSource(lambda: nullcontext(NoMicrophone()))
