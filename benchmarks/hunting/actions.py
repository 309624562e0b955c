"""What may happen to a program that drives a robot, in four tables by what must follow."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from random import Random
from typing import Any, NamedTuple

from hunting.hunted_robot import FAULTS, HANGS

BOUND = 0.5
"""All have to stand still so soon, s."""

BY_ANOTHER = 0.6
"""The same where another process has to notice first, s."""


class Turn(NamedTuple):
    """One action in a run."""

    it: Any  # the program, a `Run` or a `Node`; the features that an action needs say which
    chance: Random  # what the action chooses by
    undo: ExitStack  # what has to be undone when it was judged
    note: Callable[[str], None]  # writes down what was chosen, for who reads of a find


class Action(NamedTuple):
    """Something that happens."""

    name: str  # in the report
    needs: str  # the features of the program that it needs, all of them
    do: Callable[[Turn], object]  # does it; gives when it counts from, if not from its end
    bound: float = BOUND  # all have to stand still so soon, s
    blind: float = 0.0  # the robot `Bad` can take nothing for so long, s
    # It makes the computer later by so much than a thread that dozes can see, s.
    burdens: float = 0.0
    # After its end nothing is heard for so long, s; typed commands are obeyed then.
    heals: float = 0.0
    last: bool = False  # nothing can be commanded afterwards
    not_with: str = ""  # another action, after which this is no loss


def command(text: str) -> Callable[[Turn], object]:
    return lambda turn: turn.it.command(text)


def keys(*pieces: bytes) -> Callable[[Turn], object]:
    """Press keys, piece by piece."""

    def do(turn: Turn) -> None:
        for piece in pieces:
            turn.it.feed(piece)
            time.sleep(0.02)

    return do


def hung_reply(turn: Turn) -> None:
    """Let each reply's file in the cache hang whoever opens it, and cause one."""
    for file in (turn.it.folder / "cache").rglob("*.wav"):
        file.unlink()
        os.mkfifo(file)
    turn.it.command("stop speech")


def write_much(turn: Turn) -> None:
    """Let it tell of much that is no command."""
    for number in range(20):
        turn.it.command(f"nonsense {number} " + "na" * 100)
    time.sleep(3 if "text" in turn.it.has else 0.3)  # a line of a text lasts a cycle


def unread(turn: Turn) -> None:
    """Let nobody read what it writes, and let it write much."""
    turn.it.reading.clear()
    turn.undo.callback(turn.it.reading.set)
    write_much(turn)


def ctrl_s(turn: Turn) -> None:
    turn.it.feed(b"\x13")
    turn.undo.callback(turn.it.feed, b"\x11")
    write_much(turn)


def flood_of_lines(turn: Turn) -> None:
    turn.it.feed(b"nonsense\n" * turn.chance.choice([100, 500, 2000]))


def flood_of_strings(turn: Turn) -> None:
    """Let a recognizer publish without end what is no command."""
    rate = turn.chance.choice([1000, 2000, 5000])
    turn.note(f"at {rate} Hz")
    parts = turn.undo.enter_context(ExitStack())
    source, line = turn.it.another_recognizer(parts)

    def work() -> None:
        begun, sent = time.monotonic(), 0
        with suppress(BrokenPipeError, ValueError):  # it is over
            while True:
                due = int((time.monotonic() - begun) * rate)
                source.stdin.write(line * (due - sent))
                source.stdin.flush()
                sent = due
                time.sleep(0.02)

    threading.Thread(target=work, daemon=True).start()
    time.sleep(turn.chance.uniform(1, 4))


def busy(turn: Turn) -> None:
    for _ in range(os.cpu_count() or 1):
        process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
        turn.undo.callback(process.wait)
        turn.undo.callback(process.kill)
    time.sleep(0.5)


def mute(turn: Turn) -> float:
    """Let the microphone give exact zeros, by a switch or a volume."""
    what, off, on = turn.chance.choice(
        [
            ("set-source-mute mic.monitor", "1", "0"),
            ("set-source-volume mic.monitor", "0", "100%"),
            ("set-sink-mute mic", "1", "0"),
        ]
    )
    turn.note(what)
    begun = time.monotonic()
    turn.it.pactl(f"{what} {off}")
    turn.undo.callback(turn.it.pactl, f"{what} {on}")
    return begun


def kill_server(turn: Turn) -> None:
    turn.it.server.kill()
    turn.undo.callback(turn.it.restart_server)


def hang_server(turn: Turn) -> None:
    turn.it.server.send_signal(signal.SIGSTOP)
    turn.undo.callback(turn.it.server.send_signal, signal.SIGCONT)


def hearing(statement: str) -> Callable[[Turn], object]:
    """Run a statement with each block that the recognizer gets."""

    def do(turn: Turn) -> None:
        turn.undo.callback(turn.it.demand("hearing", statement).unlink)

    return do


def raise_in_thread(name: str, then: str = "") -> Callable[[Turn], object]:
    """Raise an exception in a thread, without a name in any of the program's own."""

    def do(turn: Turn) -> None:
        error = turn.chance.choice(["RuntimeError", "SystemExit", "KeyboardInterrupt"])
        file = turn.it.demand("thread", f"{name or turn.chance.randrange(10)} {error}")
        deadline = time.monotonic() + 2
        while file.exists() and time.monotonic() < deadline:
            time.sleep(0.005)
        hit = [path.name.removeprefix(file.name) for path in file.parent.glob(f"{file.name} *")]
        turn.note(f"{error} in{','.join(hit)}")
        if then:
            turn.it.command(then)

    return do


def kill_watchdog(turn: Turn) -> None:
    for process in turn.it.processes():
        if process != turn.it.process.pid:
            os.kill(process, signal.SIGKILL)
    turn.it.command("stop")


def pause(everything: bool, watched: bool) -> Callable[[Turn], object]:
    """Stop it for a time, alone or with all its children, as a laptop's suspend does."""

    def do(turn: Turn) -> float:
        seconds = turn.chance.uniform(0.8, 2)
        turn.note(f"for {seconds:.1f} s")
        send = turn.it.signal_all if everything else turn.it.process.send_signal
        begun = time.monotonic()
        send(signal.SIGSTOP)
        time.sleep(seconds)
        continued = time.monotonic()
        send(signal.SIGCONT)
        return begun if watched else continued

    return do


def pause_shortly(turn: Turn) -> None:
    """So shortly that it may drive on."""
    turn.it.process.send_signal(signal.SIGSTOP)
    time.sleep(turn.chance.uniform(0.1, 0.3))
    turn.it.process.send_signal(signal.SIGCONT)


def break_robot(fault: str) -> Callable[[Turn], object]:
    def do(turn: Turn) -> None:
        turn.it.demand("robot", fault)
        time.sleep(0.1)  # the robot looks with each event

    return do


def send_signals(turn: Turn) -> None:
    """Send one signal that ends it, or two close together."""
    ending = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
    ending += [signal.SIGQUIT] if "run" in turn.it.has else []
    for number in turn.chance.choices(ending, k=turn.chance.choice([1, 1, 2])):
        turn.note(number.name)
        with suppress(ProcessLookupError):
            turn.it.process.send_signal(number)
        time.sleep(turn.chance.uniform(0, 0.05))


SIGNAL = Action("signal", "", send_signals)

STOPS = [
    Action("stop", "", command("stop")),
    Action("stop speech", "", command("stop speech")),
    Action("stop speech, the reply's file hangs", "speaks", hung_reply),
    # From the end of the recording.
    Action("stop, spoken", "mic", lambda turn: turn.it.speak("stop"), bound=1.5),
    Action("space", "keys", keys(b" ")),
    Action("Escape", "keys", keys(b"\x1b")),
    Action("g, space", "keys", keys(b"g", b" ")),
    Action("go, two spaces", "keys", keys(b"go", b" ", b" ")),
    Action("go f, Escape", "keys", keys(b"go f", b"\x1b")),
    Action("arrow, space", "keys", keys(b"\x1b[A", b" ")),
    Action("arrow in pieces, space", "keys", keys(b"\x1b", b"[", b"A", b" ")),
]
"""Who commands it wants all to stand still."""

LOSSES = [
    Action("muted", "mic", mute, bound=2 * BOUND, heals=1),  # zeros are a loss after 0.5 s
    Action("sound server killed", "mic", kill_server, heals=4),
    Action("sound server hangs", "mic", hang_server, heals=4),
    Action("recognizer raises", "mic", hearing("raise RuntimeError('broken')"), heals=5),
    Action("recognizer exits", "mic", hearing("raise SystemExit(0)"), last=True),
    Action("recognizer hangs", "mic", hearing("time.sleep(3)"), heals=5),
    Action("recognizer is slow", "mic", hearing("time.sleep(0.06)"), bound=1.5, heals=5),
    Action("hearing's thread dies", "mic", raise_in_thread("voz-hearing"), last=True),
    Action("any thread dies, stop", "run", raise_in_thread("", "stop"), last=True),
    Action("watchdog killed, stop", "watchdog strings", kill_watchdog, last=True),
    Action("paused", "", pause(False, watched=False)),
    Action("paused, watched", "watchdog", pause(False, watched=True), BY_ANOTHER),
    Action("all paused", "", pause(True, watched=False)),
    *[
        Action(f"robot {fault}", "robot", break_robot(fault), last=True)
        for fault in FAULTS
        if fault not in ("hangs", "holds Python")
    ],
    Action("robot hangs", "robot", break_robot("hangs"), blind=HANGS, last=True),
    # In the program's own process nothing can be done about it. How long depends on the computer.
    Action(
        "robot holds Python",
        "robot watchdog",
        break_robot("holds Python"),
        blind=2 * HANGS,
        last=True,
    ),
    Action(
        "recognizer killed",
        "ros1",
        lambda turn: turn.it.recognizer.kill(),
        last=True,
        not_with="flood of strings",  # which comes from another one
    ),
    Action("master killed", "ros1", lambda turn: turn.it.ros.master.kill(), last=True),
]
"""Something that it needs is lost, so that all have to stand still."""

HINDRANCES = [
    Action("outputs unread", "", unread),
    Action("Ctrl-S", "terminal", ctrl_s),
    Action("200,000 letters", "lines", command("na" * 100_000)),
    Action("flood of lines", "mic", flood_of_lines),  # all of a --text has its time
    Action("flood of strings", "strings", flood_of_strings, burdens=0.2),
    Action("bad bytes", "run pipes", keys(b"\xff\xfe\n")),
    Action("busy processor", "", busy, burdens=0.2),
    Action("paused shortly", "", pause_shortly),
]
"""Nothing of this may hold up what has to follow something else."""

ENDS = [
    SIGNAL,
    Action("Ctrl-C", "terminal", keys(b"\x03")),
    Action("terminal closed", "terminal", lambda turn: turn.it.close_terminal()),
    Action("main thread raises", "run", raise_in_thread("MainThread")),
    Action("killed", "watchdog", lambda turn: turn.it.process.kill(), BY_ANOTHER),
]
"""The program has to end, and all to stand still."""

ACTIONS = [*STOPS, *LOSSES, *HINDRANCES, *ENDS]
