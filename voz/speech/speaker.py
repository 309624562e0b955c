"""Says the robot's replies beside the control cycle, which never waits for them."""

from __future__ import annotations

import contextlib
import queue
import threading
from types import TracebackType

from voz.audio.playback import play
from voz.errors import VozError
from voz.speech.festival import cached

LONGEST_QUEUE = 8
"""Replies that may wait; what is said later than that no longer belongs to what was done."""

CLOSING_TIME = 5.0
"""Seconds; enough for two replies of the robot's to be heard to their end."""

STOPPING_TIME = 1.0
"""Seconds; to fall silent. Python must not end while PortAudio plays: that may crash it."""


class Speaker:
    """Renders and plays replies, one after the other, on a thread of its own.

    Nothing that goes wrong stops it: each problem is kept once for `drain_warnings`, and the next
    reply is tried anew. `say` and `drain_warnings` are to be called from one thread.

        with Speaker("kal_diphone") as speaker:
            speaker.say("I am listening")

    Args:
        voice: a name from `voz.speech.festival.VOICES`.
    """

    def __init__(self, voice: str) -> None:
        self._voice = voice
        self._replies: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._warnings: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._warned: set[str] = set()
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._work, name="voz-speaker", daemon=True)
        self._thread.start()

    def say(self, text: str) -> None:
        """Queue a reply and return at once; if too many wait, the oldest is left out.

        Args:
            text: what to say. After `close` nothing is said.
        """
        if not self._thread.is_alive():
            return
        if self._replies.qsize() >= LONGEST_QUEUE:
            with contextlib.suppress(queue.Empty):  # the thread was faster: there is room
                self._replies.get_nowait()
        self._replies.put(text)

    def drain_warnings(self) -> list[str]:
        """Take the problems met since the last call.

        Returns:
            One line for each; the same line is never given twice by the same speaker.
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
        self._replies.put(None)
        try:
            self._thread.join(timeout)
        finally:  # also when Ctrl-C ends the waiting
            self._stopped.set()
            self._thread.join(STOPPING_TIME)

    def __enter__(self) -> Speaker:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close(0 if error else CLOSING_TIME)

    def _work(self) -> None:
        while (text := self._replies.get()) is not None and not self._stopped.is_set():
            try:
                play(cached(text, self._voice), self._stopped)
            except VozError as error:
                self._warn(str(error))

    def _warn(self, line: str) -> None:
        if line not in self._warned:
            self._warned.add(line)
            self._warnings.put(line)
