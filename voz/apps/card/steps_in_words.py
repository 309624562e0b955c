"""What a command does, in words for those who give it; pure."""

from __future__ import annotations

from collections.abc import Sequence

from voz.control.steps import Amount, Step
from voz.control.table import is_selection


def describe_steps(steps: Sequence[Step]) -> str:
    """Describe the steps of a command, as in `drives forward at 0.1 m/s, then stands still`.

    Slots stay as they are, in braces. Without a step it is a matter of the robot's own program.
    """
    if not steps:
        return "is up to the robot's program"
    return ", then ".join(map(_step, steps))


def _step(step: Step) -> str:
    parts = [_action(step)] if step.actions else []
    if step.say is not None:
        parts.append(f"says “{step.say}”")
    if step.play is not None:
        parts.append(f"plays {step.play}")
    told = ", and ".join(parts)
    if isinstance(step.confirm, str):
        return f"asks “{step.confirm}”, then {told}"
    return f"asks first, then {told}" if step.confirm else told


def _action(step: Step) -> str:
    (action,) = step.actions
    if action in ("drive", "turn", "rotate"):
        return _motion(step)
    if action in ("publish", "run", "call"):
        return _outside(step)
    fixed = {
        "faster": "goes faster",
        "slower": "goes slower",
        "stop": "stands still",
        "again": "does the last motion again",
        "listen": "wakes up" if step.listen else "stands still and sleeps",
        "answer": "answers yes" if step.answer else "answers no",
        "state": f"goes on to “{step.state}”" if step.state else "goes back to the first commands",
    }
    return fixed[action]


def _motion(step: Step) -> str:
    if step.drive is not None:
        parts = ["drives" + _side(step.drive, " forward", " back")]
        parts += [f"{_shown(step.metres)} m"] if step.metres is not None else []
        parts += [f"at {abs(step.drive):g} m/s"] if isinstance(step.drive, float | int) else []
    elif step.turn is not None:
        parts = ["turns" + _side(step.turn, " left", " right"), "while it drives"]
    else:
        assert step.rotate is not None
        parts = ["turns" + _side(step.rotate, " left", " right"), "on the spot"]
    if step.degrees is not None:
        parts.append(f"by {_shown(step.degrees)}°")
    if step.seconds is not None:
        parts.append(f"for {_shown(step.seconds)} s")
    return " ".join(parts)


def _outside(step: Step) -> str:
    if step.run is not None:
        return f"starts {step.run[0]}"
    if step.call is not None:
        return f"calls {str(step.call[0]).rpartition(':')[2]}"
    if is_selection(step):
        return f"selects object {step.publish}"
    value = str(step.publish).lower() if isinstance(step.publish, bool) else step.publish
    return f"sends {value} to {step.topic}"


def _side(amount: Amount, positive: str, negative: str) -> str:
    """Which way a velocity leads; a slot says it itself."""
    if isinstance(amount, str):
        return ""
    return positive if amount > 0 else negative


def _shown(amount: Amount) -> str:
    return amount if isinstance(amount, str) else f"{amount:g}"
