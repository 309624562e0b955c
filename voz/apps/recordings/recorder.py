"""Records what is heard while the microphone is listened to."""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import NamedTuple, TypeAlias

from voz.apps.recordings.manifest import Kind
from voz.apps.recordings.recent_sound import Excerpt, RecentSound
from voz.apps.recordings.recording_folder import RecordingFolder
from voz.audio import Samples
from voz.errors import AudioError
from voz.events import Utterance

BYTES_PER_GIGABYTE = 1_000_000_000

MOST_UNSAVED = 20
"""Jobs that wait for a slow disk: utterances and corrections."""

RECORDER_CLOSE_TIMEOUT = 2.0
"""To write what is waiting when the run ends, s."""

MOST_UNREAD_SAVED = 100
"""Entries in `Recorder.kept` that nobody has read yet."""


class SavedRecording(NamedTuple):
    """A recording that was written: where its utterance begins in the run, s, and its file."""

    start: float
    file: str


_Job: TypeAlias = Callable[[RecordingFolder], None]


class Recorder:
    """Writes recordings on a thread of its own, so that the disk delays nobody.

    A failure of the disk is reported once, and the run goes on. Use it in a `with` block.

    Attributes:
        folder: where the recordings go.
        kept: what was written; whoever reads it removes it.
    """

    def __init__(self, folder: Path, gigabytes: float, warn: Callable[[str], None]) -> None:
        """Prepare to record, with a limit on the size of all recordings in the folder."""
        self.folder = folder
        self.kept: deque[SavedRecording] = deque(maxlen=MOST_UNREAD_SAVED)
        self._said = f"what is said is recorded in {folder}"
        self._limit = gigabytes * BYTES_PER_GIGABYTE
        self._warn = warn
        self._recent = RecentSound()
        self._waiting: queue.Queue[_Job | None] = queue.Queue(MOST_UNSAVED)
        self._late = False
        self._thread = threading.Thread(target=self._work, name="voz-recorder", daemon=True)

    @property
    def note(self) -> str:
        """The notice that is shown while it records; empty once it has failed."""
        return self._said if self._thread.is_alive() else ""

    def feed(self, block: Samples) -> None:
        """Take the next samples of the microphone."""
        for excerpt in self._recent.feed(block):
            self._put(excerpt)

    def mark(self, utterance: Utterance, begun: float) -> None:
        """Record an utterance of a stream that began at this time of the run, s."""
        self._recent.mark(utterance.start - begun, utterance.end - begun, utterance)

    def end_stream(self) -> None:
        """End a stream; another one follows."""
        for excerpt in self._recent.finish():
            self._put(excerpt)
        self._recent = RecentSound()

    def correct(self, file: str, text: str, kind: Kind) -> Future[None]:
        """Write into the manifest what was really said; the future may raise AudioError or OSError.

        Raises:
            AudioError: recording has failed, or the disk is too slow.
        """
        done: Future[None] = Future()

        def job(folder: RecordingFolder) -> None:
            try:
                folder.correct(file, text, kind)
                done.set_result(None)
            except (AudioError, OSError, UnicodeDecodeError) as error:
                done.set_exception(error)

        if not self._thread.is_alive():
            raise AudioError(f"{self.folder}: nothing is recorded any more; start `voz run` anew")
        try:
            self._waiting.put_nowait(job)
        except queue.Full:
            raise AudioError(f"{self.folder}: the disk is too slow; try again") from None
        return done

    def __enter__(self) -> Recorder:
        self._warn(self._said)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if not self._thread.is_alive():
            return
        try:
            self._waiting.put(None, timeout=RECORDER_CLOSE_TIMEOUT)
        except queue.Full:
            return
        self._thread.join(RECORDER_CLOSE_TIMEOUT)

    def _put(self, excerpt: Excerpt) -> None:
        try:
            self._waiting.put_nowait(lambda folder: self._keep(excerpt, folder))
        except queue.Full:
            if not self._late and self._thread.is_alive():
                self._late = True
                self._warn(f"{self.folder}: the disk is too slow; not everything is recorded")

    def _keep(self, excerpt: Excerpt, folder: RecordingFolder) -> None:
        self.kept.append(SavedRecording(excerpt.utterance.start, folder.add(excerpt)))

    def _work(self) -> None:
        try:
            folder = RecordingFolder(self.folder, self._limit)
            while (job := self._waiting.get()) is not None:
                job(folder)
        except AudioError as error:
            self._warn(f"nothing is recorded: {error}")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "no UTF-8 text"
            self._warn(f"nothing more is recorded: {self.folder}: cannot be written ({reason})")
