"""The display of a live run: level, what was heard, motion, reply."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from typing import Protocol

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from voz.audio.recording_level import MIN_SNR
from voz.events import Event, Notice, Reply, SelectedObject, Twist, Utterance, explain_not_obeyed
from voz.printable import printable
from voz.robot.console import motion_in_words
from voz.texts import ENGLISH, text, translate

MAX_LINES = 6
"""Utterances and warnings that are shown."""

BAR_WIDTH = 30
"""Characters of the level bar."""

BAR_MIN_DBFS = -60.0
"""The level at which the bar is empty, dBFS: a quiet room."""

CLIPPING_DBFS = -3.0
"""Above this a microphone is about to clip, dBFS."""

PANEL_WIDTH = 76

MIN_SIDE_WIDTH = 40
"""Characters that `extra` needs beside the panel; with less it is drawn below."""

KEYS_HELP = "space or Esc stops the robot, typed commands work too, Ctrl-C ends"

TYPING_HELP = "Esc or two spaces stop the robot, Enter obeys the line, Ctrl-C ends"
"""While a command is typed: the space between its words does not stop the robot."""


class HeardSound(Protocol):
    """What is shown of a microphone."""

    peak: float  # its level now, 0 to 1
    background: float  # level of the room, dBFS
    speaking: bool  # whether the robot speaks, so that only `never_missed` commands are obeyed
    device: str  # its name


class ListeningState(Protocol):
    """What is shown of a controller."""

    @property
    def listening(self) -> bool:
        """Whether commands are obeyed."""

    @property
    def awake(self) -> bool:
        """Whether spoken commands count: it has no name, or that was said."""

    @property
    def wake(self) -> str:
        """What is said to begin the listening; empty if nothing is."""

    @property
    def name(self) -> str:
        """What the robot is called; empty if it has no name."""


class Display:
    """Collects events, and draws them when rich asks for it."""

    def __init__(
        self,
        sound: HeardSound,
        ear: ListeningState,
        typing: Callable[[], str],
        note: Callable[[], str] = lambda: "",
        *,
        extra: RenderableType | None = None,
        language: str = ENGLISH,
    ) -> None:
        """Start with nothing heard.

        `typing` returns the line that is being typed, `note` a text that is always shown. `extra`
        is drawn beside the panel, or below it in a narrow terminal.
        """
        self._sound = sound
        self._device = sound.device
        self._ear = ear
        self._typing = typing
        self._note = note
        self._extra = extra
        self._language = language
        self._lines: deque[Text] = deque(maxlen=MAX_LINES)
        self._velocity = (0.0, 0.0)
        self._selected: int | None = None
        self._reply = ""
        self._above: float | None = None  # how far the last utterance stood out of the room, dB

    def receive(self, event: Event) -> None:
        """Take an event; it is shown at the next refresh."""
        if isinstance(event, Twist):
            self._velocity = (event.linear, event.angular)
        elif isinstance(event, SelectedObject):
            self._selected = event.value
        elif isinstance(event, Reply):
            self._reply = event.text
        elif isinstance(event, Utterance | Notice):
            if isinstance(event, Utterance) and event.above is not None:
                self._above = event.above
            self._lines.append(_event_text(event, self._language))

    def __rich__(self) -> RenderableType:
        return PanelWithExtra(self._panel(), self._extra) if self._extra else self._panel()

    def _panel(self) -> Panel:
        table = Table.grid(padding=(0, 2))
        table.add_column(style="dim", justify="right")
        table.add_column()
        for label, shown in self._rows():
            table.add_row(label and text(label, self._language), shown)
        keys = Text(text(TYPING_HELP if self._typing() else KEYS_HELP, self._language), "dim")
        return Panel(Group(table), title=self._title(), subtitle=keys, width=PANEL_WIDTH)

    def _rows(self) -> Iterator[tuple[str, Text]]:
        """What is shown in each line, by an English label."""
        language = self._language
        yield "microphone", _level_text(self._sound.peak, language)
        yield "", Text(printable(self._device), "dim", no_wrap=True)
        yield "room", _room_text(self._sound.background, self._above, language)
        yield "robot", Text(motion_in_words(*self._velocity, language), "bold")
        if self._selected is not None:
            yield "arm", Text(_arm_in_words(self._selected, language))
        yield "says", Text(printable(self._reply))
        for number in range(MAX_LINES):
            line = self._lines[number] if number < len(self._lines) else Text()
            yield "heard" if number == 0 else "", line
        yield "type", Text(self._typing() + "▏")
        if note := self._note():
            yield "", Text(printable(translate(note, language)), "yellow")

    def _title(self) -> Text:
        ear, language = self._ear, self._language
        if self._sound.speaking:
            return Text(text(" speaking ", language), "black on yellow")
        if not ear.awake:
            return Text(printable(text(' asleep: say "{name}" ', language, name=ear.name)))
        if ear.listening:
            return Text(text(" listening ", language), "black on green")
        if ear.wake:
            return Text(printable(text(' say "{command}" ', language, command=ear.wake)))
        return Text(text(" not listening ", language))


class PanelWithExtra:
    """A panel and something else, beside it in a wide terminal, below it in others."""

    def __init__(self, panel: Panel, other: RenderableType) -> None:
        self._panel = panel
        self._other = other

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        if options.max_width < PANEL_WIDTH + MIN_SIDE_WIDTH:
            yield self._panel
            used = len(console.render_lines(self._panel, options))
            yield from console.render(
                self._other, options.update(height=max(1, options.size.height - used))
            )
            return
        both = Table.grid(padding=(0, 1))
        both.add_row(self._panel, self._other)
        yield both


def _arm_in_words(selected: int, language: str) -> str:
    if selected < 100:
        return text("object {number}", language, number=selected)
    return text("folded", language)


def _level_text(peak: float, language: str) -> Text:
    decibels = max(BAR_MIN_DBFS, 20 * math.log10(peak)) if peak > 0 else BAR_MIN_DBFS
    full = round(BAR_WIDTH * (1 - decibels / BAR_MIN_DBFS))
    color = "red" if decibels > CLIPPING_DBFS else "green"
    silent = f"  {text('silent', language)}"
    shown = f"{decibels:4.0f} dB" if decibels > BAR_MIN_DBFS else silent
    return Text.assemble(("█" * full, color), ("·" * (BAR_WIDTH - full), "dim"), f" {shown}")


def _room_text(background: float, above: float | None, language: str) -> Text:
    level = Text(f"{background:4.0f} dB")
    if above is not None:
        color = "yellow" if above < MIN_SNR else "green"
        last = ", the last speech {level} dB above it"
        level.append(text(last, language, level=f"{above:.0f}"), color)
    return level


def _event_text(event: Utterance | Notice, language: str) -> Text:
    if isinstance(event, Notice):
        told = translate(event.text, language)
        return Text(printable(told), "green" if event.good else "yellow")
    said = printable(event.text)
    if event.obeyed:
        late = f"  {event.latency:.2f} s" if event.latency is not None else ""
        return Text.assemble((said, "bold"), (f"  {event.confidence:.0%}{late}", "dim"))
    why = explain_not_obeyed(event, language)
    if event.accepted:
        return Text(f"{said}  {why}", "dim")
    sure = f"{event.confidence:.0%}"
    maybe = 'perhaps "{text}" {confidence}, '
    perhaps = text(maybe, language, text=said, confidence=sure) if said else ""
    return Text(f"({perhaps}{why})", "dim")
