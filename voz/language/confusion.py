"""Which commands sound alike to the acoustic model.

The distance of two commands is what the recogniser would lose, in log-likelihood for each frame,
by taking one for the other: each phone that is said is explained by the phones of the other
command, in order, and lasts as long as it does. So it is no plain edit distance: a hidden Markov
model stretches a phone over as many frames as it likes for nothing but the mismatch, and skips
one in no less than three. How badly one phone explains another is measured, see
`tools/fit_confusion.py`.

Only `read_distances` and `draw` do I/O.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, islice, permutations, product, takewhile
from pathlib import Path

from voz.errors import VozError

DISTANCES = Path(__file__).with_name("phone_distances.tsv")

UNLIKE = 7.5
"""Nats that a frame loses on average when a phone is explained by one with nothing in common."""

LEAST_FRAMES = 3
"""A phone's model has three states, and each takes a frame at least."""

RISKY = 0.77
"""From here on a pair is worth a warning.

In the list that comes with voz these are four pairs, `start speech` and `stop speech` first.
"""

NOTEWORTHY = 0.65
"""From here on a pair is worth a place in the table."""

MOST_COMMANDS = 100
"""More are not compared when they are built: it takes a time that grows with their square.

14 commands take 10 ms, 100 about a second, 300 ten times as long; of so many, dozens are alike.
"""

MOST_PICTURED = 60
"""More make a picture that nobody can read."""

MOST_VARIANTS = 8
"""Ways to say a command that are compared; a sentence of many words can have thousands."""

MOST_WARNINGS = 5

NEVER_REWORDED = frozenset({"stop"})
"""The one command that works always (S1 in DESIGN.md): everybody must be able to guess it."""


@dataclass(frozen=True)
class Distances:
    """How far apart the acoustic model holds the phones.

    Attributes:
        frames: how many frames of 10 ms a phone lasts.
        apart: what a frame of the first phone loses, in nats, if it is taken for the second.
    """

    frames: Mapping[str, float]
    apart: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class AlikePair:
    """Two commands and how alike they sound.

    Attributes:
        first: the command that stands first in the list.
        second: the other.
        alike: 1 if they sound the same, near 0 if nothing in them does.
        differ: the phones of each that the other does not share at its beginning or end.
    """

    first: str
    second: str
    alike: float
    differ: tuple[str, str]


@dataclass(frozen=True)
class _Spoken:
    """One way to say a command, with what comparing it needs again and again."""

    phones: tuple[str, ...]
    frames: float
    cheapest: Mapping[str, float]  # what each phone loses at least if explained by this command


@cache
def read_distances(path: Path = DISTANCES) -> Distances:
    """Read the table of phone distances that comes with voz."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header, *rows = (line.split("\t") for line in lines if not line.startswith("#"))
    frames = {phone: float(length) for phone, length, *_ in rows}
    apart = {row[0]: dict(zip(header[2:], map(float, row[2:]), strict=True)) for row in rows}
    return Distances(frames, apart)


def sound_alike(
    commands: Sequence[str],
    pronunciations: Mapping[str, Sequence[str]],
    at_least: float = NOTEWORTHY,
) -> list[AlikePair]:
    """Find the pairs of commands that sound alike.

    Args:
        commands: normalised sentences, each once.
        pronunciations: the pronunciations of each of their words, such as "K OW L AH".
        at_least: how alike a pair must be, 0 to 1; the higher, the faster.

    Returns:
        The pairs, the most alike first.
    """
    distances = read_distances()
    farthest = -math.log(at_least) * UNLIKE if at_least > 0 else math.inf
    spoken = {command: _ways_to_say(command, pronunciations, distances) for command in commands}
    pairs = []
    for first, second in combinations(commands, 2):
        loss, said = _closest(spoken[first], spoken[second], distances, farthest)
        if loss <= farthest:
            alike = math.exp(-loss / UNLIKE)
            pairs.append(AlikePair(first, second, alike, _difference(*said)))
    return sorted(pairs, key=lambda pair: -pair.alike)


def warnings(pairs: Sequence[AlikePair]) -> tuple[str, ...]:
    """Tell the user which pairs are risky, and which of the two to reword.

    Args:
        pairs: what `sound_alike` gives.

    Returns:
        A line for each pair, the most alike first; if there are many, a few and how many more.
    """
    risky = [pair for pair in pairs if pair.alike >= RISKY]
    lines = [_warning(pair, pairs) for pair in risky[:MOST_WARNINGS]]
    if more := len(risky) - len(lines):
        lines.append(f"{more} more pairs sound as alike; `voz build-lm --alike` shows the closest")
    return tuple(lines)


def reword(pair: AlikePair, pairs: Iterable[AlikePair]) -> str:
    """Suggest which command of a pair to reword: the one that is also close to more others.

    Args:
        pair: the two commands.
        pairs: all pairs that sound alike.

    Returns:
        The command; of two that are equally close to others the one that is later in the list.
    """
    others = [other for other in pairs if other != pair]

    def closeness(command: str) -> float:
        return sum(other.alike for other in others if command in (other.first, other.second))

    candidates = [c for c in (pair.second, pair.first) if c not in NEVER_REWORDED]
    return max(candidates, key=closeness)


def table(pairs: Sequence[AlikePair], count: int = 10) -> str:
    """Write the closest pairs as a table.

    Args:
        pairs: what `sound_alike` gives.
        count: how many at most.

    Returns:
        Lines to print; one that says so if there are no such pairs.
    """
    if not pairs:
        return "no two commands sound alike"
    rows = [("alike", "commands", "", "what differs")]
    rows += [(f"{p.alike:.2f}", p.first, p.second, _versus(p)) for p in pairs[:count]]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)
    return "\n".join(lines)


def draw(commands: Sequence[str], pronunciations: Mapping[str, Sequence[str]], path: Path) -> None:
    """Draw how alike all commands sound, as a matrix.

    Args:
        commands: normalised sentences, each once.
        pronunciations: the pronunciations of each of their words.
        path: the picture; its ending decides between PNG and SVG.

    Raises:
        VozError: matplotlib is missing, there are too many commands, or the picture cannot be
            written.
    """
    if path.suffix.lower() not in (".png", ".svg"):
        raise VozError(f"{path}: is no name for a picture; end it with .png or .svg")
    if len(commands) > MOST_PICTURED:
        raise VozError(
            f"{len(commands)} commands are too many for a picture; give a list of at most "
            f"{MOST_PICTURED}"
        )
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise VozError(
            "matplotlib is missing; install it with: pip install 'voz[report]'"
        ) from None
    figure = Figure(figsize=(3 + len(commands) / 2, 2 + len(commands) / 2), layout="constrained")
    axes = figure.add_subplot()
    cells = _matrix(commands, pronunciations)
    # Two commands are rarely under 0.4: with colours from 0 on all would be the same red.
    image = axes.imshow(cells, cmap="YlOrRd", vmin=0.4, vmax=1.0)
    figure.colorbar(image, shrink=0.8)
    places = range(len(commands))
    axes.set_xticks(places, commands, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(places, commands)
    for row, column in permutations(places, 2):
        alike = cells[row][column]
        colour, weight = ("white", "bold") if alike >= RISKY else ("black", "normal")
        axes.text(
            column, row, f"{alike:.2f}", ha="center", va="center", fontsize=8,
            color=colour, weight=weight,
        )  # fmt: skip
    axes.set_title("How alike the commands sound; bold: worth a warning")
    try:
        figure.savefig(path, dpi=120)
    except OSError as error:
        raise VozError(f"{path}: cannot be written ({error.strerror})") from None


def _matrix(
    commands: Sequence[str], pronunciations: Mapping[str, Sequence[str]]
) -> list[list[float]]:
    pairs = sound_alike(commands, pronunciations, at_least=0.0)
    alike = {frozenset((pair.first, pair.second)): pair.alike for pair in pairs}
    return [[alike.get(frozenset((row, column)), 1.0) for column in commands] for row in commands]


def _ways_to_say(
    command: str, pronunciations: Mapping[str, Sequence[str]], distances: Distances
) -> list[_Spoken]:
    words = [pronunciations[word] for word in command.split()]
    ways = (" ".join(parts).split() for parts in islice(product(*words), MOST_VARIANTS))
    return [_spoken(tuple(phones), distances) for phones in ways]


def _spoken(phones: tuple[str, ...], distances: Distances) -> _Spoken:
    present = set(phones)
    cheapest = {
        phone: distances.frames[phone] * min(apart[other] for other in present)
        for phone, apart in distances.apart.items()
    }
    return _Spoken(phones, sum(distances.frames[phone] for phone in phones), cheapest)


def _closest(
    first: Sequence[_Spoken], second: Sequence[_Spoken], distances: Distances, farthest: float
) -> tuple[float, tuple[_Spoken, _Spoken]]:
    """Compare two commands in all ways to say them; a loss above `farthest` may be any such."""
    said = (first[0], second[0])
    least = math.inf
    for one, other in product(first, second):
        # Most pairs are far apart even if order and length did not matter: that is cheap to see.
        if _at_least(one, other) > min(farthest, least):
            continue
        # One direction alone may lose twice as much as both on average.
        there = _loss(one, other, distances, 2 * farthest)
        back = _loss(other, one, distances, 2 * farthest - there)
        loss = (there + back) / 2
        if loss < least:
            least, said = loss, (one, other)
    return least, said


def _at_least(one: _Spoken, other: _Spoken) -> float:
    """Bound the loss from below: each phone is explained by the best of the other command."""
    there = sum(map(other.cheapest.__getitem__, one.phones)) / one.frames
    back = sum(map(one.cheapest.__getitem__, other.phones)) / other.frames
    return (there + back) / 2


def _loss(said: _Spoken, taken: _Spoken, distances: Distances, farthest: float) -> float:
    """Compute what each frame of one command loses if it is taken for the other, in nats.

    Dynamic programming: `losses[n]` is the least loss if, of what was said so far, n phones of
    `taken` are the explanation. A phone that was said is explained by the next phone of `taken`
    or by a neighbour of that place; a phone of `taken` that nobody said takes its least frames
    from what was said around it. A loss above `farthest` is not computed to its end.
    """
    costs = [[distances.apart[phone][other] for other in taken.phones] for phone in said.phones]
    losses = [0.0]
    for each in costs[0]:
        losses.append(losses[-1] + LEAST_FRAMES * each)
    for phone, cost, following in zip(said.phones, costs, [*costs[1:], costs[-1]], strict=True):
        losses = _next_losses(losses, cost, following, distances.frames[phone])
        if min(losses) > farthest * said.frames:
            return math.inf
    return losses[-1] / said.frames


def _next_losses(
    losses: Sequence[float], cost: Sequence[float], following: Sequence[float], frames: float
) -> list[float]:
    """Go on by one phone that was said; written for speed, for it takes nearly all the time."""
    before = cost[0]
    least = losses[0] + frames * before
    reached = [least]
    for place, now in enumerate(cost):
        after = following[place]
        unsaid = least + LEAST_FRAMES * (now if now < after else after)
        as_next = losses[place] + frames * now
        ahead = cost[place + 1] if place + 1 < len(cost) else now
        beside = losses[place + 1] + frames * (now if now < ahead else ahead)
        least = min(unsaid, as_next, beside)
        reached.append(least)
    return reached


def _difference(one: _Spoken, other: _Spoken) -> tuple[str, str]:
    """Leave out the phones that both begin with, and those that both end with."""
    first, second = one.phones, other.phones
    begin = _shared(first, second)
    first, second = first[begin:], second[begin:]
    end = _shared(first[::-1], second[::-1])
    return " ".join(first[: len(first) - end]), " ".join(second[: len(second) - end])


def _shared(first: Iterable[str], second: Iterable[str]) -> int:
    """Count the phones that are the same before the first that is not."""
    same = (one == other for one, other in zip(first, second, strict=False))
    return sum(1 for _ in takewhile(bool, same))


def _warning(pair: AlikePair, pairs: Sequence[AlikePair]) -> str:
    differ = f"{_versus(pair)} differ" if any(pair.differ) else "no phone differs"
    return (
        f'"{pair.first}" and "{pair.second}" sound alike ({pair.alike:.2f}: {differ}); '
        f'use another word for one, best in "{reword(pair, pairs)}"'
    )


def _versus(pair: AlikePair) -> str:
    return " / ".join(phones or "nothing" for phones in pair.differ) if any(pair.differ) else ""
