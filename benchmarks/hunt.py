"""Hunts for a way to let the robot drive on, by faults and moments that a seed chooses.

Run `python benchmarks/hunt.py --minutes N [--seed S] [--target live|robot|text|ros1|ros2]`. Each
run starts a real program that hears a microphone without hardware, drives, does what its seed
chooses, and sees outside, as a base would, whether zero velocity came in half a second and stayed
until the next command, and whether it came last of all. What it finds is printed with its target
and its seed, which repeat it with `--runs 1` (and the same `--always`). For `ros1` and `ros2` it
needs what `make test` installs.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections import Counter
from pathlib import Path

from machine import machine

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from hunting.actions import ACTIONS
from hunting.run import Hunt, hunt
from hunting.targets import TARGETS


def summary(hunts: list[Hunt]) -> str:
    took = [each for done in hunts for each in done.took]
    found = [names for done in hunts for names, _ in done.finds]
    lines = [f"{'':38} times  worst time to zero  finds"]
    for name in [action.name for action in ACTIONS]:
        times = [seconds for names, seconds in took if name in names]
        if times:
            finds = sum(name in names for names in found)
            lines.append(f"{name:38} {len(times):5}  {max(times):16.2f} s  {finds:5}")
    lines.append(f"{len(hunts)} runs, {len(found)} finds; it could not be driven on:")
    stuck = Counter(f"{done.target} {done.stuck}" for done in hunts if done.stuck)
    lines += [f"{number:5} times: {why}" for why, number in stuck.items()]
    return "\n".join(lines)


def main() -> None:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # what was started ends too
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=20)
    parser.add_argument("--runs", type=int, default=10**9, help="at most")
    parser.add_argument(
        "--seed", type=int, default=1, help="of the first run; the next has the next"
    )
    parser.add_argument("--target", choices=TARGETS, action="append", help="may be repeated")
    parser.add_argument("--always", default="", metavar="ACTION", help="one of them all the time")
    parser.add_argument("--verbose", action="store_true", help="print each run's schedule")
    arguments = parser.parse_args()
    targets = arguments.target or TARGETS
    until = time.monotonic() + 60 * arguments.minutes
    hunts: list[Hunt] = []
    print(machine(), flush=True)
    while time.monotonic() < until and len(hunts) < arguments.runs:
        count = len(hunts)
        done = hunt(
            targets[count % len(targets)], arguments.seed + count // len(targets), arguments.always
        )
        hunts.append(done)
        if done.finds or done.stuck or arguments.verbose:
            print(f"\n{done}", flush=True)
    print(f"\n{summary(hunts)}")
    sys.exit(any(done.finds for done in hunts))


if __name__ == "__main__":
    main()
