"""What a speaker is asked to say."""

from __future__ import annotations

import numpy as np

from voz.enrolment import PROMPTS, missing, prompts
from voz.recognition.calibration import Said


def test_each_command_is_asked_for_and_some_twice_in_the_same_order_each_time() -> None:
    commands = [f"command {number}" for number in range(14)]
    asked = prompts(commands, "ana")
    assert asked == prompts(commands, "ana") != prompts(commands, "juan")
    assert (len(asked), set(asked)) == (PROMPTS, set(commands))
    assert len(set(prompts([str(n) for n in range(1000)], "ana"))) == PROMPTS


def test_what_is_recorded_is_not_asked_for_again() -> None:
    nothing = np.zeros(0, np.int16)
    assert missing(["a", "b", "a", "c"], [Said("a", nothing), Said("c", nothing)]) == ["b", "a"]
