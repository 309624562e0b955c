"""Says the robot's replies without making the control loop wait."""

from __future__ import annotations

import contextlib
import logging
import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from voz.audio.playback import PLAYBACK_RATE
from voz.audio.sound_files import read_sound
from voz.errors import VozError
from voz.speech.sound_client import SoundClient, mixer_of
from voz.speech.synthesis import cached_speech, is_cached

_log = logging.getLogger("voz")

MAX_QUEUED_REPLIES = 8
"""A later reply would no longer belong to what was done."""

LAST_REPLIES_TIMEOUT = 5.0
"""Enough for two of the robot's replies, s."""

SPEAKER_STOP_TIMEOUT = 1.0
"""For the threads to end once all is silent, s."""


@dataclass(frozen=True)
class _QueuedReply:
    """A text, and whether it has just been rendered; or a sound."""

    text: str
    interruptions: int  # when it was queued
    is_rendered: bool = False
    is_sound: bool = False


class ReplySpeaker:
    """Says replies one after the other, on two threads: one renders new texts, one plays.

    So a hanging festival does not delay a reply that is rendered already. An error is one warning,
    and the next reply is tried.

        with ReplySpeaker("kal_diphone") as speaker:
            speaker.say("I am listening")

    Args:
        voice: one of `voz.speech.synthesis.VOICES`, or of espeak-ng.
        prepared: replies to render at the start.
        warn: called with each message once, on any thread, or again if the loudspeaker was back.
        barge_in: whether commands count while it speaks.

    Attributes:
        client: plays the replies, and other sounds.
        mixer: the client's.
    """

    def __init__(
        self,
        voice: str,
        prepared: Sequence[str] = (),
        warn: Callable[[str], None] = _log.warning,
        *,
        barge_in: bool = False,
    ) -> None:
        self._voice = voice
        self._prepared = prepared
        self._warn = warn
        self._unrendered: queue.SimpleQueue[_QueuedReply | None] = queue.SimpleQueue()
        self._to_say: queue.SimpleQueue[_QueuedReply | None] = queue.SimpleQueue()
        self._warned: set[str] = set()
        self._interruptions = 0
        self._closing = threading.Event()
        self._stopped = threading.Event()
        self.client = SoundClient(voice, blocking=True, warn=warn)
        self.mixer = mixer_of(self.client)
        self.mixer.barge_in = barge_in
        self._threads = [
            threading.Thread(target=work, name="voz-speaker", daemon=True)
            for work in (self._render, self._speak)
        ]
        for thread in self._threads:
            thread.start()

    def say(self, text: str) -> None:
        """Queue a reply; if too many wait, the oldest is dropped. Nothing is said after `close`."""
        self._queue(_QueuedReply(text, self._interruptions))

    def play(self, sound: str) -> None:
        """Queue a sound: the title of a built-in one, or a file."""
        self._queue(_QueuedReply(sound, self._interruptions, is_sound=True))

    def interrupt(self) -> None:
        """Fall silent at once, within 30 ms, and forget what is queued."""
        self._interruptions += 1
        self.client.stop_all()

    def _queue(self, reply: _QueuedReply) -> None:
        if self._closing.is_set():
            return
        if self._to_say.qsize() >= MAX_QUEUED_REPLIES:
            with contextlib.suppress(queue.Empty):  # the thread was faster: there is room
                self._to_say.get_nowait()
        self._to_say.put(reply)

    def close(self, timeout: float = LAST_REPLIES_TIMEOUT) -> None:
        """Say what is queued, for at most `timeout` seconds, then end."""
        deadline = time.monotonic() + timeout
        if not self._closing.is_set():
            self._closing.set()
            self._to_say.put(None)
        try:
            self._join(deadline)
        finally:  # also when Ctrl-C ends the waiting
            self._stopped.set()
            self.client.close()
            self._join(time.monotonic() + SPEAKER_STOP_TIMEOUT)

    def __enter__(self) -> ReplySpeaker:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(LAST_REPLIES_TIMEOUT if kind is None else 0)

    def _join(self, deadline: float) -> None:
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))

    def _render(self) -> None:
        for text in self._prepared:
            with contextlib.suppress(VozError):  # reported when the reply is said
                # Read it too: the first read loads a library.
                read_sound(cached_speech(text, self._voice, self._closing), PLAYBACK_RATE)
        while (reply := self._unrendered.get()) is not None:
            try:
                cached_speech(reply.text, self._voice, self._stopped)
                self._to_say.put(replace(reply, is_rendered=True))
            except VozError as error:
                if not self._stopped.is_set():
                    self._tell(error)
        self._to_say.put(None)

    def _speak(self) -> None:
        self.mixer.prepare()
        for last in (False, True):
            while (reply := self._to_say.get()) is not None and not self._stopped.is_set():
                self._take(reply)
            if not last:
                self._unrendered.put(None)  # replies that are being rendered come before the end

    def _take(self, reply: _QueuedReply) -> None:
        try:
            # Checked here, not in `say`: a disk may hang, and the robot must not wait.
            if reply.interruptions < self._interruptions:
                return
            if reply.is_sound:
                self.client.play_named(reply.text)
            elif reply.is_rendered or is_cached(reply.text, self._voice):
                self.client.say(reply.text)
            else:
                self._unrendered.put(reply)
        except VozError as error:
            self._tell(error)

    def _tell(self, error: VozError) -> None:
        if str(error) not in self._warned:
            self._warned.add(str(error))
            self._warn(str(error))
