"""Tries whether the tests of what keeps a robot safe notice each small change to it.

Run `python benchmarks/mutants.py`, or with a part of a module's path. Each mutant is a module with
one change: another comparison, `not`, `and` for `or`, another number, `min` for `max`, a statement
left out. It is alive if the module's tests pass with it all the same. Mutants are in memory alone;
no file is changed. Those that cannot be told from the original are `EQUIVALENT`, each with its
reason; one that is listed there and is killed, or exists no more, is an error too.
"""

from __future__ import annotations

import argparse
import ast
import math
import os
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType, ModuleType
from typing import Any

import pytest
from machine import machine
from rich.console import Console
from rich.progress import Progress

ROOT = Path(__file__).resolve().parent.parent

MAX_TIMES = 3
"""A mutant is killed whose tests take this many times longer than without it: one never ends."""

MAX_SECONDS = 300
"""The same for one that waits for ever."""

MAX_MEMORY = 4 << 30
"""The same for one that fills the memory, bytes."""


@dataclass(frozen=True)
class Target:
    """A module, the tests that have to notice its mutants, and what of it is changed."""

    module: str  # its file
    tests: tuple[str, ...]  # files of tests; the quickest that is likely to notice first
    only: frozenset[str] = frozenset()  # functions, classes and constants; all if empty


MODULES = (
    "motion", "state_machine", "safety", "table", "attention", "steps", "messages", "controller",
)  # fmt: skip
CONTROL = tuple(f"tests/control/test_{name}.py" for name in MODULES)


def own_first(name: str) -> tuple[str, ...]:
    """The tests of `voz/control`, those of a module first."""
    return tuple(sorted(CONTROL, key=lambda test: f"test_{name}" not in test))


LOCK = ("tests/apps/web/test_parts.py", "tests/apps/web/test_driving_page.py")
WATCHDOG = frozenset(
    ("RUN_TIMEOUT", "ZERO_INTERVAL", "FINAL_ZEROS", "WatchedRobot", "_serve", "_stop_after_run")
)

CONTROLLER = frozenset(("Controller", "MAX_TIME", "_is_time", "_check_time"))

TARGETS = [
    *(Target(f"voz/control/{name}.py", own_first(name)) for name in MODULES),
    Target("voz/run/controller.py", ("tests/run/test_controller.py",), CONTROLLER),
    Target("voz/run/session.py", ("tests/run/test_session.py", "tests/run/test_clocks.py")),
    Target("voz/inbox.py", ("tests/test_inbox.py",)),
    Target("voz/robot/child.py", ("tests/robot/test_child.py",), WATCHDOG),
    Target("voz/apps/web/driver_lock.py", LOCK),
]

READ_LATER = "it is set before it is read"

EQUIVALENT = {
    "voz/control/motion.py": {
        "faster: motion.linear > 0 -> motion.linear >= 0": "it is not 0 there",
    },
    "voz/control/safety.py": {
        "_thousandths: round(velocity * PER_UNIT, 6) -> round(velocity * PER_UNIT, 7)": (
            "a product of floats is off by less than either"
        ),
    },
    "voz/control/state_machine.py": {
        "_step_events: step.publish is not None and step.topic is not None -> "
        "step.publish is not None or step.topic is not None": "a step has both or neither",
    },
    "voz/control/table.py": {
        "_check: {True, False} <= _answers(table, state) -> "
        "{True, False} < _answers(table, state)": "what asks is no answer: there is a third value",
    },
    "voz/control/controller.py": {
        "ControllerState: last_command: float = 0.0 -> last_command: float = 1.0": READ_LATER,
        "ControllerState: Attention(0.0, awake=True) -> Attention(1.0, awake=True)": (
            "its time is not looked at"
        ),
    },
    "voz/inbox.py": {
        "Inbox: __init__: itertools.count(1) -> itertools.count(0)": "numbers are only compared",
        "Inbox: __init__: itertools.count(1) -> itertools.count(2)": "numbers are only compared",
        "Inbox: __init__: self._arrived.acquire() -> pass": "the first wait looks once more",
        "Inbox: __init__: self._newest_stop = 0 -> self._newest_stop = 1": "no number is below 1",
        "Inbox: take: left <= 0 -> left < 0": "a wait of 0 s is none",
        "Inbox: take: number < self._newest_stop -> number <= self._newest_stop": (
            "what is not a stop has another number"
        ),
    },
    "voz/run/session.py": {
        "if TYPE_CHECKING: -> if not TYPE_CHECKING:": "modules are loaded earlier, and no more",
    },
    "voz/apps/web/driver_lock.py": {
        "DriverLock: __init__: self._last_answer = 0.0 -> pass": READ_LATER,
        "DriverLock: __init__: self._last_answer = 0.0 -> self._last_answer = 1.0": READ_LATER,
    },
}
"""Mutants that do what the original does, by module and as they are printed, and why."""


# What a mutant is

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,), ast.NotIn: (ast.In,), ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.LtE), ast.GtE: (ast.Gt, ast.Lt),
}  # fmt: skip
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult
}  # fmt: skip
FUNCTIONS = {"min": "max", "max": "min", "any": "all", "all": "any"}


@dataclass
class Mutant:
    """A changed module: where, what was changed, its code, and whether its tests noticed."""

    line: int
    change: str
    code: CodeType = field(repr=False)
    killed: bool = False


def mutants(path: Path, only: frozenset[str]) -> list[Mutant]:
    """Make all mutants of a module, or of some names in it."""
    tree = ast.parse(path.read_text())
    made: list[Mutant] = []
    for top in tree.body:
        names = {getattr(top, "name", "")} | {
            target.id for target in getattr(top, "targets", []) if isinstance(target, ast.Name)
        }
        if not only or names & only:
            place = f"{getattr(top, 'name', '')}: ".removeprefix(": ")
            for line, change in changes(top, place):
                made.append(Mutant(line, change, compile(tree, str(path), "exec")))
    count: Counter[str] = Counter()
    for mutant in made:  # the second that reads the same is told from the first
        count[mutant.change] += 1
        mutant.change += f" #{count[mutant.change]}" if count[mutant.change] > 1 else ""
    return made


def changes(parent: ast.AST, place: str) -> Iterator[tuple[int, str]]:
    """Change what is in a node, one at a time; each change is undone after it was yielded."""
    line = getattr(parent, "lineno", 0)
    for name, value in ast.iter_fields(parent):
        if name in ("decorator_list", "keywords") and isinstance(parent, ast.ClassDef):
            continue  # `frozen` and the like: what may be written, not what is done
        if name in ("annotation", "returns") and not isinstance(parent, ast.AnnAssign):
            continue
        many = isinstance(value, list)
        for at, child in enumerate(value if many else [value]):
            if not isinstance(child, ast.AST):
                continue
            for new in replacements(child, parent, name):
                shown = child if isinstance(child, (ast.expr, ast.stmt)) else parent
                small = isinstance(child, (ast.Constant, ast.Name))
                shown = parent if small and not isinstance(parent, ast.Module) else shown
                before = text(shown)
                put(parent, name, at if many else None, new)
                after = text(new if shown is child else shown)
                yield getattr(child, "lineno", line), f"{place}{before} -> {after}"
                put(parent, name, at if many else None, child)
            inner = f"{child.name}: " if isinstance(child, (ast.FunctionDef, ast.ClassDef)) else ""
            yield from changes(child, place + inner)


def put(parent: ast.AST, name: str, at: int | None, child: ast.AST) -> None:
    """Put another node in the place of one."""
    if at is None:
        setattr(parent, name, child)
    else:
        getattr(parent, name)[at] = child
    ast.fix_missing_locations(parent)


def text(node: ast.AST) -> str:
    """A node as Python, of a statement its first line."""
    return ast.unparse(node).splitlines()[0]


def replacements(node: ast.AST, parent: ast.AST, name: str) -> Iterator[ast.AST]:
    """What may stand in place of a node, by mistake."""
    if isinstance(node, ast.expr):
        yield from other_values(node)
        returned = name == "value" and isinstance(parent, ast.Return)
        truth = returned and isinstance(node, ast.BoolOp)
        condition = name == "test" or (name == "ifs" and isinstance(parent, ast.comprehension))
        negated = isinstance(node, ast.Compare) or is_not(node)  # which has been done above
        if (condition or truth) and not negated:
            yield ast.copy_location(ast.UnaryOp(ast.Not(), node), node)
    elif isinstance(node, ast.cmpop):
        yield from (other() for other in COMPARISONS[type(node)])
    elif isinstance(node, ast.boolop):
        yield ast.Or() if isinstance(node, ast.And) else ast.And()
    elif isinstance(node, ast.operator) and type(node) in OPERATORS:
        yield OPERATORS[type(node)]()
    elif may_be_left_out(node):
        yield ast.copy_location(ast.Pass(), node)


def other_values(node: ast.expr) -> Iterator[ast.expr]:
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool):
            yield ast.copy_location(ast.Constant(not node.value), node)
        elif isinstance(node.value, (int, float)):
            more = node.value + 1 if isinstance(node.value, int) else node.value * 1.5 or 1.0
            for value in {more, 0} if node.value else {more}:
                yield ast.copy_location(ast.Constant(value), node)
    elif is_not(node) or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)):
        yield node.operand  # type: ignore[attr-defined]
    elif isinstance(node, ast.Name) and node.id in FUNCTIONS:
        yield ast.copy_location(ast.Name(FUNCTIONS[node.id], node.ctx), node)


def is_not(node: ast.AST) -> bool:
    return isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)


def may_be_left_out(node: ast.AST) -> bool:
    """Whether a statement is a call, raises, counts, or sets an attribute of `self`."""
    if isinstance(node, ast.Assign):
        parts = [part for target in node.targets for part in ast.walk(target)]
        return any(isinstance(part, ast.Attribute) for part in parts)
    called = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    return called or isinstance(node, (ast.Raise, ast.AugAssign))


# How its tests are run


class Mutated(MetaPathFinder, Loader):
    """Imports the mutant in place of its module."""

    def __init__(self, path: Path, code: CodeType) -> None:
        self._path = path
        self._code = code
        self._name = ".".join(path.relative_to(ROOT).with_suffix("").parts)

    def find_spec(self, fullname: str, *_: Any) -> ModuleSpec | None:
        """Find the one module."""
        if fullname != self._name:
            return None
        return spec_from_file_location(fullname, self._path, loader=self)

    def exec_module(self, module: ModuleType) -> None:
        """Run the mutant as its code."""
        exec(self._code, module.__dict__)


def pytest_result(arguments: list[str]) -> int:
    quick = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist"]
    return int(pytest.main([*quick, *arguments]))


def in_a_child(work: Callable[[], int], cpu_seconds: int) -> int:
    """Begin a process that does something, and may neither last nor grow; return its number."""
    child = os.fork()
    if child:
        return child
    with suppress(BaseException):
        nowhere = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(nowhere, descriptor)
        signal.alarm(MAX_SECONDS)
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds))
        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
        os._exit(work())
    os._exit(1)


def load_what_tests_need(tests: set[str]) -> None:
    """Import what all mutants share: everything but the modules of voz and of its tests."""
    sys.dont_write_bytecode = False  # each mutant needs all others of the modules again
    sys.path[0] = str(ROOT)  # not the folder of this file, whose modules hide those of tests
    os.chdir(ROOT)
    own = tuple(str(ROOT / folder) for folder in ("voz", "tests", "tools"))
    folders = {"tests", *(path.name for path in (ROOT / "tests").iterdir() if path.is_dir())}
    said, sys.stdout = sys.stdout, open(os.devnull, "w")  # noqa: PTH123, SIM115
    pytest_result(["--collect-only", *sorted(tests)])
    sys.stdout = said
    from hypothesis import Phase, settings  # not before pytest, which loads it its own way

    settings.register_profile(
        "mutants",
        deadline=None, database=None, derandomize=True, phases=[Phase.explicit, Phase.generate],
    )  # fmt: skip
    for name, module in list(sys.modules.items()):
        file = getattr(module, "__file__", None)
        if file.startswith(own) if file else name.partition(".")[0] in folders:
            del sys.modules[name]


def try_all(target: Target, jobs: int, progress: Progress) -> list[Mutant]:
    """Run a module's tests with each of its mutants."""
    path = ROOT / target.module

    def begin(code: CodeType, cpu_seconds: int) -> int:
        def work() -> int:
            sys.meta_path.insert(0, Mutated(path, code))
            return pytest_result(["--hypothesis-profile=mutants", *target.tests])

        return in_a_child(work, cpu_seconds)

    original = compile(path.read_text(), str(path), "exec")
    _, status, used = os.wait4(begin(original, MAX_SECONDS), 0)
    if status:
        sys.exit(f"{target.module}: its tests fail without a mutant, too: {target.tests}")
    made = mutants(path, target.only)
    bar = progress.add_task(target.module, total=len(made))
    limit = math.ceil(MAX_TIMES * used.ru_utime)
    waiting, running = list(made), dict[int, Mutant]()
    while waiting or running:
        while waiting and len(running) < jobs:
            mutant = waiting.pop(0)
            running[begin(mutant.code, limit)] = mutant
        child, status = os.wait()
        running.pop(child).killed = status != 0
        progress.advance(bar)
        progress.refresh()
    return made


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        epilog="example: python benchmarks/mutants.py driver_lock voz/control/safety",
    )
    parser.add_argument("modules", nargs="*", metavar="MODULE", help="a part of its path")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="at the same time")
    arguments = parser.parse_args()
    wanted = arguments.modules or [""]
    targets = [each for each in TARGETS if any(part in each.module for part in wanted)]
    if not targets:
        parser.error(f"none of {', '.join(each.module for each in TARGETS)}")
    with TemporaryDirectory() as sys.pycache_prefix:
        sys.exit(report(targets, arguments.jobs))


def report(targets: list[Target], jobs: int) -> bool:
    """Try the mutants, print what they did, and return whether something is wrong."""
    load_what_tests_need({test for target in targets for test in target.tests})
    print(machine(), flush=True)
    print(f"{'':30} mutants  killed  equivalent  alive  seconds")
    wrong: list[str] = []
    with Progress(console=Console(stderr=True), auto_refresh=False, transient=True) as progress:
        for target in targets:
            begun = time.monotonic()
            made = try_all(target, jobs, progress)
            alive = {mutant.change: mutant for mutant in made if not mutant.killed}
            listed = EQUIVALENT.get(target.module, {})
            wrong += [f"{target.module}: killed, or no more: {x}" for x in listed.keys() - alive]
            found = [mutant for change, mutant in alive.items() if change not in listed]
            wrong += [f"{target.module}:{each.line}: alive: {each.change}" for each in found]
            print(
                f"{target.module:30} {len(made):7} {len(made) - len(alive):7} "
                f"{len(alive) - len(found):11} {len(found):6} {time.monotonic() - begun:8.0f}",
                flush=True,
            )
    print("\n".join(wrong))
    return bool(wrong)


if __name__ == "__main__":
    main()
