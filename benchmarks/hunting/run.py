"""Hunts for a way to let a robot drive on: moments and faults by a seed, in a real program."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from hunting.actions import ENDS, HINDRANCES, LOSSES, SIGNAL, STOPS, Action, Turn
from hunting.observing import Observer, judge
from hunting.quarry import Quarry
from hunting.targets import quarry

NOISE = 0.1
"""What other work on the computer may add to how late it is seen to be, s."""

WATCHED = (0.3, 1.0)
"""So long it is watched whether all go on to stand still, s."""

ENDED = 40.0
"""A program that takes longer to end never does, s."""

STARTS = 40.0
MOVES = 15.0
"""One that takes longer for these does not, s."""

CRASHED = 1
"""The exit code of Python after an exception that nobody expected."""


@dataclass
class Hunt:
    """A run of a program, and what came of it."""

    target: str  # what was hunted
    seed: int  # repeats it
    schedule: list[str] = field(default_factory=list)  # what was done, and when
    # Until zero, s, with the names of what caused it and of what could hold it up.
    took: list[tuple[list[str], float]] = field(default_factory=list)
    # What is wrong, with the same names.
    finds: list[tuple[list[str], str]] = field(default_factory=list)
    stuck: str = ""  # why it could not be driven on; that is safe, but may be wrong

    def __str__(self) -> str:
        ends = [f"  not driven on: {self.stuck}"] if self.stuck else []
        ends += [f"  FOUND after {', '.join(names)}: {wrong}" for names, wrong in self.finds]
        return "\n".join([f"--target {self.target} --seed {self.seed}", *self.schedule, *ends])


def hunt(target: str, seed: int, always: str = "") -> Hunt:
    """Run a target once.

    Args:
        target: one of `TARGETS`.
        seed: chooses how it is set up, and what happens; the same chooses the same again.
        always: the name of an action that is among what happens wherever it is possible.
    """
    chance = Random(f"{target} {seed}")
    done = Hunt(target, seed)
    with ExitStack() as parts:
        folder = Path(parts.enter_context(tempfile.TemporaryDirectory(prefix="voz-hunt-")))
        observer = parts.enter_context(Observer(folder / "observer"))
        it = quarry(target, chance, folder, parts, observer)
        parts.callback(it.end)
        done.schedule += [f"  {setup}" for setup in it.setup]
        hunter = _Hunter(it, observer, done, always)
        if always == SIGNAL.name or (not always and chance.random() < 0.3):
            hunter.end_early(chance)
        else:
            hunter.drive_and_stop(chance)
        if done.finds or done.stuck:
            done.schedule += [f"  | {line[:160]}" for line in it.stacks()]
    return done


class _Hunter:
    """What it does to a program, and what it sees of it."""

    def __init__(self, it: Quarry, observer: Observer, done: Hunt, always: str) -> None:
        self._it, self._observer, self._done, self._always = it, observer, done, always
        self._begun = time.monotonic()

    def end_early(self, chance: Random) -> None:
        """End it while it starts; a command waits for it, so that it drives at once."""
        self._it.command("go forward")
        self._it.start()
        moment = self._it.spawned + chance.triangular(0.05, 1.5, 0.3)
        while time.monotonic() < moment:
            time.sleep(max(0.0, min(0.05, moment - time.monotonic())))
            if "ros1" in self._it.has:  # what was published before is lost
                self._it.command("go forward")
        self._act(SIGNAL, self._turn(chance))

    def drive_and_stop(self, chance: Random) -> None:
        """Let it drive, and stop it in some way, some times; then end it."""
        stops, losses = self._possible(STOPS), self._possible(LOSSES)
        actions = [chance.choice(chance.choice([stops, losses])) for _ in range(3)]
        actions = self._wanted(stops + losses, actions[: chance.randint(1, 3)])
        actions += self._wanted(self._possible(ENDS), [chance.choice(self._possible(ENDS))])
        self._it.start()
        if not self._eventually(lambda: self._observer.seen, STARTS):
            self._give_up("it does not start")
        driven = True
        for action in actions:
            if self._done.finds or self._done.stuck or not (driven or action in ENDS):
                continue
            if driven and not self._drives():
                self._give_up("it does not move")
                continue
            self._round(action, Random(chance.random()))
            driven = not action.last

    def _round(self, action: Action, chance: Random) -> None:
        """Let something happen, and what may hold up the rest before that."""
        hindering, turn = self._hindering(action, chance), self._turn(chance)
        time.sleep(chance.uniform(0.1, 0.8))
        with turn.undo:
            for hindrance in hindering:
                self._note(hindrance.name)
                hindrance.do(turn)
            self._act(action, turn, hindering)
        time.sleep(action.heals)

    def _hindering(self, action: Action, chance: Random) -> list[Action]:
        others = [each for each in self._possible(HINDRANCES) if each.name != action.not_with]
        return self._wanted(others, chance.sample(others, chance.choice([0, 1, 1, 2])))

    def _wanted(self, possible: Sequence[Action], chosen: list[Action]) -> list[Action]:
        """Those that were chosen, or in their place the one that always has to be."""
        return [action for action in possible if action.name == self._always] or chosen

    def _possible(self, actions: Sequence[Action]) -> list[Action]:
        return [action for action in actions if set(action.needs.split()) <= self._it.has]

    def _act(self, action: Action, turn: Turn, hindering: Sequence[Action] = ()) -> None:
        self._note(action.name)
        begun, ends = time.monotonic(), action in ENDS
        since = action.do(turn)
        if not isinstance(since, float):
            since = begun if ends else time.monotonic()
        if ends:
            with suppress(subprocess.TimeoutExpired):
                self._it.process.wait(ENDED)
        watched = since + action.bound + action.blind + turn.chance.uniform(*WATCHED)
        time.sleep(max(0.0, watched - time.monotonic()))
        self._judge(action, since, hindering)

    def _judge(self, action: Action, since: float, hindering: Sequence[Action]) -> None:
        names = [action.name, *(each.name for each in hindering)]
        late = self._observer.lateness(since)
        bound = action.bound + late + NOISE + sum(each.burdens for each in hindering)
        took, wrong = judge(list(self._observer.seen), since, bound, action.blind)
        self._done.took.append((names, took))
        wrongs = [wrong] if wrong else []
        if action in ENDS and self._it.process.poll() is None:
            wrongs.append(f"it did not end in {ENDED:g} s")
        if wrongs:
            told = f"{'; '.join(wrongs)} (the computer was late by {late:.2f} s)"
            self._done.finds.append((names, told))

    def _drives(self) -> bool:
        """Command it to drive until it does."""
        self._note("go forward")
        begun = time.monotonic()

        def drives() -> bool:
            self._it.command("start speech")
            self._it.command("go forward")
            return self._eventually(lambda: self._observer.moves(begun), 0.5)

        return self._eventually(drives, MOVES)

    def _eventually(self, happens: Callable[[], object], seconds: float) -> bool:
        deadline = time.monotonic() + seconds
        while not happens():
            if time.monotonic() > deadline or self._it.process.poll() is not None:
                return False
            time.sleep(0.01)
        return True

    def _give_up(self, reason: str) -> None:
        code = self._it.process.poll()
        self._done.stuck = reason if code is None else f"it ended with code {code}"
        injured = any("dies" in names[0] for names, _ in self._done.took)
        if code == CRASHED and not injured:
            names = self._done.took[-1][0] if self._done.took else ["the start"]
            self._done.finds.append((names, "it crashed"))

    def _turn(self, chance: Random) -> Turn:
        return Turn(self._it, chance, ExitStack(), self._note)

    def _note(self, text: str) -> None:
        self._done.schedule.append(f"  {time.monotonic() - self._begun:6.2f} s  {text}")
