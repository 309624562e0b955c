"""The sound of the driving page: its microphone, and what it plays.

Its sound comes over one WebSocket, in blocks with a number and a time. A microphone near it must
not take what it plays for commands.
"""

from __future__ import annotations

import queue
import struct
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from voz.apps.servers.connections import RateLimit
from voz.apps.web.page_messages import Begin, Finish, FromMicrophone, Hello, Pong
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.channels import Mono
from voz.audio.segment import NO_SAMPLES
from voz.audio.sound_files import Resampler
from voz.hearing.half_duplex import Playback

BROWSER_SOURCE = "browser"
"""The source of utterances from there."""

MAX_AUDIO_AGE = 0.3
"""Sound that is older when it arrives is dropped, s: a late `forward` must never drive."""

MAX_BROWSER_BLOCKS = 60
"""Blocks that wait for a slow computer, about a second; then all are dropped."""

POLL_INTERVAL = 0.1
"""How often the thread that listens looks for its end while nobody speaks, s."""

LATE_WARNING_INTERVAL = 5.0
"""Between two warnings of late or missing sound, s."""


@dataclass(frozen=True, slots=True)
class _Block:
    """A block, its rate in Hz, when it was heard on the monotonic clock, s, and `addressed`."""

    sound: Mono
    rate: float
    when: float
    addressed: bool


@dataclass(frozen=True, slots=True)
class _End:
    """A stream ends, complete or not."""

    complete: bool


_Item: TypeAlias = _Block | _End


class BrowserMicrophone:
    """The sound of the driving page, stream by stream.

    The server's thread calls the methods with a verb, the thread that listens iterates. Its
    attributes are those of `OpenMicrophone`.
    """

    name = "of the operator's browser"
    blocks_lost = 0
    out_of_phase = False

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Begin with no stream; `warn` takes a line when sound is late or missing."""
        self.arrived = time.monotonic()
        self.complete = True
        self.addressed = False
        self._warn = warn
        self._warned_at = -LATE_WARNING_INTERVAL
        self._waiting: queue.Queue[_Item] = queue.Queue(MAX_BROWSER_BLOCKS)
        self._resampler: Resampler | None = None  # of the current stream
        self._rate = 0.0
        self._held = False  # the button, for the current stream
        self._expected = False
        self._last = 0.0  # when sound came that was not late, on the monotonic clock, s
        self._broken = False  # sound is missing, and the stream was ended for that

    @property
    def alive(self) -> float:
        """When sound last arrived, on the monotonic clock, s; now while none is expected."""
        return self._last if self._expected else time.monotonic()

    @alive.setter
    def alive(self, when: float) -> None:
        self._last = when

    @property
    def is_expected(self) -> bool:
        """Whether sound is expected: the button is held, or the page is hands-free."""
        return self._expected

    @property
    def is_hands_free(self) -> bool:
        """Whether sound is expected without a button that is held."""
        return self._expected and not self._held

    def begin_stream(self, rate: float, held: bool) -> None:
        """Expect sound from now on, at so many Hz; `held`: for as long as the button is held."""
        self.end_stream(complete=False)
        self._last, self._rate, self._held = time.monotonic(), rate, held
        self._expected, self._broken = True, False

    def take_block(self, sound: Mono, when: float) -> float | None:
        """Take a block that was heard at a time on the monotonic clock, s.

        Returns:
            How late it was if it is dropped for that, s; None if it counts.
        """
        if not self._expected:
            return None
        now = time.monotonic()
        if now - when > MAX_AUDIO_AGE:
            self._break(f"sound of the browser came {now - when:.1f} s late and is dropped")
            return now - when
        self._last, self._broken = now, False
        self._put(_Block(sound, self._rate, when, self._held))
        return None

    def note_gap(self) -> None:
        """Note that blocks are missing before the next one."""
        if self._expected:
            self._break("sound of the browser is missing: the network is too slow")

    def end_stream(self, complete: bool) -> None:
        """Expect no more sound; decide an open segment if the stream is complete, else drop it."""
        if self._expected:
            self._expected = False
            self._put(_End(complete))

    def note_page_gone(self) -> None:
        """Note that the page has gone; if it was to speak, sound is still expected (S5)."""
        if self._expected:
            self._put(_End(False))

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        try:
            item = self._waiting.get(timeout=POLL_INTERVAL)
        except queue.Empty:
            self.arrived = time.monotonic()
            return NO_SAMPLES
        if isinstance(item, _End):
            self.complete, self._resampler = item.complete, None
            raise StopIteration
        self._resampler = self._resampler or Resampler(item.rate)
        self.arrived, self.addressed = item.when, item.addressed
        return self._resampler.feed(item.sound)

    def _break(self, why: str) -> None:
        """End the stream without its open segment, in which words may be missing."""
        now = time.monotonic()
        if not self._broken:
            self._broken = True
            self._put(_End(False))
        if now - self._warned_at >= LATE_WARNING_INTERVAL:
            self._warned_at = now
            self._warn(why)

    def _put(self, item: _Item) -> None:
        try:
            self._waiting.put_nowait(item)
        except queue.Full:  # nobody needs sound that has waited for a second
            with suppress(queue.Empty):
                while True:
                    self._waiting.get_nowait()
            self._waiting.put_nowait(_End(False))


BLOCK_RATE, BLOCK_BURST = 100.0, 300.0
"""Blocks per second, and at once: a page sends 40 to 60, and more after a delay of the network."""

MAX_CLOCK_LEAD = 0.1
"""A block may seem to come from the future by so much, s; with more its clock is wrong."""

BLOCK_HEADER = struct.Struct("<IId")
"""Number of the block, 0, and when its last sample was heard, ms by the page's clock."""

MAX_BLOCK_SAMPLES = 9_600
"""0.1 s at 96 kHz."""

MAX_CLOCK_ANSWERS = 8
"""Answers from which the two clocks are compared."""


@dataclass(frozen=True, slots=True)
class AudioBlock:
    """A block of sound: its number, when it was heard (ms), and floats from -1 to 1."""

    number: int
    heard: float
    sound: npt.NDArray[np.float32]


def read_block(data: bytes) -> AudioBlock | None:
    """Read a block as the page sends it, 16-bit samples after a header; None if it is invalid."""
    samples, odd = divmod(len(data) - BLOCK_HEADER.size, 2)
    if odd or not 0 < samples <= MAX_BLOCK_SAMPLES:
        return None
    number, zero, heard = BLOCK_HEADER.unpack_from(data)
    if zero or not np.isfinite(heard):
        return None
    sound = np.frombuffer(data, "<i2", offset=BLOCK_HEADER.size).astype(np.float32)
    return AudioBlock(number, heard, sound / np.float32(32768))


class PageClock:
    """How far a page's clock is ahead of this computer's, from pings that it answers."""

    def __init__(self) -> None:
        # The round trip, and how far the page's clock is ahead, s.
        self._answers: deque[tuple[float, float]] = deque(maxlen=MAX_CLOCK_ANSWERS)

    @property
    def is_known(self) -> bool:
        """Whether there is an answer yet."""
        return bool(self._answers)

    def add_answer(self, sent: float, received: float, page: float) -> None:
        """Take the answer to a ping: when it was sent and received, and the page's time, s."""
        self._answers.append((received - sent, page - (received + sent) / 2))

    def age(self, heard: float, now: float) -> float:
        """Return how old sound is, s, that was heard at a time by the page's clock, s."""
        _, ahead = min(self._answers)  # the shortest round trip has the smallest error
        return now - (heard - ahead)


class PageAudioStream:
    """Passes the messages of a page on to the microphone; an invalid one raises ValueError."""

    def __init__(self, microphone: BrowserMicrophone, rate: float) -> None:
        """Begin with no sound, at a rate in Hz."""
        self._microphone = microphone
        self._rate = rate
        self._clock = PageClock()
        self._limit = RateLimit(BLOCK_RATE, BLOCK_BURST)
        self._next: int | None = None

    def take_message(self, message: FromMicrophone | None) -> None:
        """Take a message; raises ValueError if it may not come now."""
        if message is None or isinstance(message, Hello):
            raise ValueError
        if isinstance(message, Pong):
            now = time.monotonic()
            if message.t > now:
                raise ValueError
            self._clock.add_answer(message.t, now, message.at / 1000)
        elif isinstance(message, Begin) and self._clock.is_known:
            self._next = None
            self._microphone.begin_stream(self._rate, message.held)
        elif isinstance(message, Finish):
            self._microphone.end_stream(complete=True)

    def take_block(self, data: bytes) -> float | None:
        """Take a block of sound; raises ValueError if it is invalid, or there are too many.

        Returns:
            How late it was if it is dropped for that, s; None if it counts.
        """
        now = time.monotonic()
        block = read_block(data)
        if block is None or not self._limit.allows(now):
            raise ValueError
        if not self._clock.is_known:
            return None
        if self._next is not None and block.number != self._next:
            self._microphone.note_gap()
        self._next = block.number + 1
        age = self._clock.age(block.heard / 1000, now)
        if age < -MAX_CLOCK_LEAD:  # the page's clock was set: unknown until the next answer
            self._microphone.note_gap()
            return None
        return self._microphone.take_block(block.sound, now - max(0.0, age))

    def skip_block(self) -> None:
        """Leave out a block of a page that counts as gone."""
        self._microphone.note_gap()

    def close(self) -> None:
        """Note that the page has gone."""
        self._microphone.note_page_gone()


PLAYBACK_DELAY = 1.0
"""A page may begin so much later than it says, s: wireless loudspeakers take a third of it."""


MAX_REPLIES = 4
"""Replies that are remembered: what they left in the room lasts for less."""


@dataclass(frozen=True, slots=True, eq=False)
class PageReply:
    """A reply that a page plays: its text, and its samples, 16 kHz, -1 to 1."""

    text: str
    sound: npt.NDArray[np.float32]


class PagePlayback:
    """The robot's own playback, and that of the driving page.

    Of a page's only the end is known, if it is no reply of the robot's. The server's thread calls
    `start`, the microphone's thread the others.
    """

    def __init__(self) -> None:
        self.robot: Playback | None = None  # the robot's own playback, if it has any
        self._until = 0.0  # on the monotonic clock, s
        self._played: tuple[tuple[float, PageReply], ...] = ()  # with when they began, s
        self._is_reply = False  # what is played now

    def start(self, seconds: float, reply: PageReply | None = None) -> None:
        """Note that a page plays for so long, in place of what it played before."""
        now = time.monotonic()
        self._is_reply = reply is not None and seconds > 0
        if reply:
            self._played = (*self._played, (now, reply))[-MAX_REPLIES:]
        self._until = now + seconds + PLAYBACK_DELAY

    def busy_until(self) -> float:
        """When the last of it has left a loudspeaker, on the monotonic clock, s."""
        return max(self._until, self.robot.busy_until() if self.robot else 0.0)

    def replies(self) -> str | None:
        """What the page, or the robot, says, if that is a reply and all that sounds; else None."""
        now = time.monotonic()
        if self.robot and self.robot.busy_until() > now:
            return self.robot.replies() if self._until <= now else None
        return self._played[-1][1].text if self._is_reply else None

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """What was played last: replies of the page if all that sounds is one, else the robot's."""
        now = time.monotonic()
        if self.robot and (not self._is_reply or self.robot.busy_until() > now):
            return self.robot.recent(seconds)
        sound = np.zeros(round(seconds * SAMPLE_RATE), np.float32)
        for begun, reply in self._played:
            place = len(sound) - round((now - begun) * SAMPLE_RATE)
            part = reply.sound[max(0, -place) :][: max(0, len(sound) - max(0, place))]
            sound[max(0, place) :][: len(part)] += part
        return sound, now
