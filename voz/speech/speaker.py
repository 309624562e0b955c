"""Says the robot's replies beside the control cycle, which never waits for them."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Sequence
from typing import TypeAlias

from voz.audio.files import read_sound
from voz.audio.mixing import RATE
from voz.errors import VozError
from voz.speech.festival import cached, is_cached
from voz.speech.sound_client import SoundClient

LONGEST_QUEUE = 8
"""Replies that may wait; what is said later than that no longer belongs to what was done."""

CLOSING_TIME = 5.0
"""Seconds; enough for two replies of the robot's to be heard to their end."""

STOPPING_TIME = 1.0
"""Seconds for the threads to end once all is silent."""

Texts: TypeAlias = "queue.SimpleQueue[str | None]"


class Speaker:
    """Says replies one after the other, on threads of its own.

    One thread lets festival render what was never said before, the other lets be heard what is
    rendered: so a festival that hangs keeps back no reply that is ready. Nothing that goes wrong
    stops it: each problem is kept once for `drain_warnings`, and the next reply is tried anew.
    `say` and `drain_warnings` are to be called from one thread.

        with Speaker("kal_diphone") as speaker:
            speaker.say("I am listening")

    Args:
        voice: a name from `voz.speech.festival.VOICES`.
        prepared: replies that are rendered at once, so that they are heard without delay.

    Attributes:
        client: what the replies go through; other sounds may be played with it.
        mixer: the client's, which tells what is heard and until when.
    """

    def __init__(self, voice: str, prepared: Sequence[str] = ()) -> None:
        self._voice = voice
        self._prepared = prepared
        self._unrendered: Texts = queue.SimpleQueue()
        self._rendered: Texts = queue.SimpleQueue()
        self._warnings: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._warned: set[str] = set()
        self._closing = threading.Event()
        self._stopped = threading.Event()
        self.client = SoundClient(voice, blocking=True, warn=self._warnings.put)
        self.mixer = self.client.mixer
        self._threads = [
            threading.Thread(target=work, name="voz-speaker", daemon=True)
            for work in (self._render, self._speak)
        ]
        for thread in self._threads:
            thread.start()

    def say(self, text: str) -> None:
        """Queue a reply and return at once; if too many wait, the oldest is left out.

        Args:
            text: what to say. After `close` nothing is said.
        """
        if self._closing.is_set():
            return
        try:
            texts = self._rendered if is_cached(text, self._voice) else self._unrendered
        except VozError as error:
            self._warn(error)
            return
        if texts.qsize() >= LONGEST_QUEUE:
            with contextlib.suppress(queue.Empty):  # the thread was faster: there is room
                texts.get_nowait()
        texts.put(text)

    def drain_warnings(self) -> list[str]:
        """Take the problems met since the last call.

        Returns:
            One line for each; the same line is given again only if the loudspeaker was back.
        """
        drained = []
        with contextlib.suppress(queue.Empty):
            while True:
                drained.append(self._warnings.get_nowait())
        return drained

    def close(self, timeout: float = CLOSING_TIME) -> None:
        """Say what is queued, then end; what is not said in time is left out.

        Args:
            timeout: how long to wait, s.
        """
        deadline = time.monotonic() + timeout
        self._closing.set()
        self._unrendered.put(None)
        try:
            self._join(deadline)
        finally:  # also when Ctrl-C ends the waiting
            self._stopped.set()
            self.client.close()
            self._join(time.monotonic() + STOPPING_TIME)

    def __enter__(self) -> Speaker:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(CLOSING_TIME if kind is None else 0)

    def _join(self, deadline: float) -> None:
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))

    def _render(self) -> None:
        for reply in self._prepared:
            with contextlib.suppress(VozError):  # which is told when the reply is said
                # Read too: the first time, that takes a library.
                read_sound(cached(reply, self._voice, self._closing), RATE)
        while (text := self._unrendered.get()) is not None:
            try:
                cached(text, self._voice, self._stopped)
                self._rendered.put(text)
            except VozError as error:
                if not self._stopped.is_set():
                    self._warn(error)
        self._rendered.put(None)

    def _speak(self) -> None:
        self.mixer.prepare()
        while (text := self._rendered.get()) is not None and not self._stopped.is_set():
            try:
                self.client.say(text)
            except VozError as error:
                self._warn(error)

    def _warn(self, error: VozError) -> None:
        if str(error) not in self._warned:
            self._warned.add(str(error))
            self._warnings.put(str(error))
