"""Whatever is given to a public function: nothing is raised but what voz raises on purpose."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import AsyncIterator, Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import voz
from voz.api.recognizer import MicrophoneUtterances, Recognizer


class Opaque:
    """Something that cannot even be shown."""

    def __repr__(self) -> str:
        raise RuntimeError("nobody shows me")


class Wheels(voz.Robot):
    def move(self, linear: float, angular: float) -> None: ...


PLAIN = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.sampled_from([10**400, -(10**5000)]),
    st.floats(),
    st.complex_numbers(),
    st.text(st.characters()),
    st.sampled_from(["no/such", "a\0b", "\udcff", "x" * 5000]),
    st.binary(),
)

ODD = [
    *(object(), Opaque(), Opaque, Wheels, voz.Utterance, Path("no/such"), Path("a\0b"), range(3)),
    *(np.array(None), np.zeros(3), np.zeros((2, 2, 2)), np.array(["a"]), np.float64("nan")),
    *(voz.Safety(), voz.Recognition(), voz.VozError("no"), voz.Robot(), [[1, 2], [3]]),
]

WRONG = st.one_of(
    PLAIN,
    st.lists(PLAIN, max_size=3),
    st.dictionaries(st.text(), PLAIN, max_size=2),
    st.sets(st.integers(), max_size=2),
    st.lists(PLAIN, max_size=2).map(iter),
    st.sampled_from(ODD),
)

SAID = voz.Utterance(0, "go forward", 1, True, 0, 0, "text")

QUIET = np.zeros(1600, np.int16)


def nothing(*_: object, **__: object) -> None: ...


Call = tuple[Callable[..., object], tuple[object, ...]]
"""A function, and arguments that it takes."""


def drives() -> Any:
    return voz.Controller([], listening=True)


def controller(*arguments: Any) -> voz.Controller:
    return voz.Controller(*arguments[:-1], commands=arguments[-1])


def decode(recognizer: Recognizer, sound: Any, rate: Any, words: Any, best: Any) -> object:
    return recognizer.decode(sound, rate, words=words, best=best)


def decode_many(*arguments: Any) -> object:
    *others, jobs, words, best = arguments
    return voz.decode_many(*others, jobs=jobs, words=words, best=best)


def made_sounds(*arguments: Any) -> None:
    voz.SoundClient(*arguments).close()


FUNCTIONS: dict[str, Callable[[Recognizer], Call]] = {
    "load": lambda _: (voz.load, (["stop"], None, None)),
    "load_config": lambda _: (voz.load_config, (Path("no/such"),)),
    "read_results": lambda _: (voz.read_results, ("no/such.csv",)),
    "decode_many": lambda _: (decode_many, ([], ["stop"], None, None, None, False, 0)),
    "Controller": lambda _: (controller, ([], None, False, None, nothing, None)),
    "Controller.hear": lambda _: (drives().hear, (SAID, False)),
    "Controller.send": lambda _: (drives().send, (1.0,)),
    "Controller.stop": lambda _: (drives().stop, (1.0, "why")),
    "Controller.take": lambda _: (drives().take, (SAID, 1.0)),
    "Controller.emit": lambda _: (drives().emit, (SAID,)),
    "Controller.zero": lambda _: (drives().zero, (1.0,)),
    "Controller.run": lambda _: (drives().run, ([],)),
    "Recognizer": lambda r: (voz.Recognizer, (r.files, voz.Recognition(), None)),
    "Recognizer.reload": lambda r: (r.reload, (nothing,)),
    "Recognizer.set_false_alarm_rate": lambda r: (r.set_false_alarm_rate, (1.0,)),
    "Recognizer.expect": lambda r: (r.expect, ((),)),
    "Recognizer.threshold_of": lambda r: (r.threshold_of, ("stop",)),
    "Recognizer.listen": lambda r: (r.listen, (16_000,)),
    "Recognizer.decode": lambda r: (partial(decode, r), (QUIET, 16_000, False, 0)),
    "Recognizer.microphone": lambda r: (r.microphone, ("no such",)),
    "Recognizer.listen_in_background": lambda r: (r.listen_in_background, (nothing, "no such")),
    "Recognizer.astream": lambda r: (r.astream, ([QUIET], 16_000)),
    "Recognizer.utterances": lambda r: (r.utterances, ([QUIET], "x")),
    "Recognizer.events": lambda r: (r.events, ([QUIET], "x")),
    "Listener": lambda _: (voz.Listener, (None, 16_000)),
    "Listener.feed": lambda r: (r.listen(16_000).feed, (QUIET,)),
    "Client": lambda _: (voz.Client, ("http://127.0.0.1:1", None, None)),
    "Robot.receive": lambda _: (voz.Robot().receive, (SAID,)),
    "Robot.move": lambda _: (voz.Robot().move, (0.0, 0.0)),
    "Robot.command": lambda _: (voz.Robot().command, ("wave", {})),
    "Robot.place": lambda _: (voz.Robot().place, (0.0,)),
    "SoundClient": lambda _: (made_sounds, ("kal_diphone", False, nothing)),
    "VozError": lambda _: (voz.VozError, ("what", "do")),
    "CommandsError": lambda _: (voz.CommandsError, ("what", "do", ())),
}

SOUND_METHODS: dict[str, tuple[object, ...]] = {
    "play": (1, 0.0, False),
    "start": (1, 0.0),
    "stop": (1,),
    "play_wave": ("no/such", 0.0, False),
    "play_named": ("no/such", 0.0, False),
    "start_wave": ("no/such", 0.0),
    "stop_wave": ("no/such",),
    "stop_saying": ("hello",),
    "builtin_sound": (1, 0.0),
    "wave_sound": ("no/such", 0.0),
    "voice_sound": ("hello", 0.0),
    "set_quiet": (True,),
}

EXEMPT = {
    "BuiltinSound": "Python's own enum compares the argument before voz sees it",
    "Client.command": "tests/apps/web/test_client.py: it needs a robot",
    "Config.__struct_fields__": "a record",
    "Decoded": "a result, which holds what it is given",
    "SoundClient.say": "festival's renderers: tests/speech/test_sound_client.py",
    "SoundClient.repeat": "the same",
}


def public_functions() -> set[str]:
    """The functions, classes and methods with arguments that `import voz` shows."""
    found = set()
    for name in voz.__all__:
        one = getattr(voz, name)
        if not inspect.isclass(one):
            found |= {name} if callable(one) else set()
            continue
        is_error = issubclass(one, voz.VozError) and "__init__" not in vars(one)
        if not (is_error or hasattr(one, "__struct_fields__") or one is voz.Robot):
            found.add(name)
        for method, function in inspect.getmembers(one, inspect.isfunction):
            takes_more = len(inspect.signature(function).parameters) > 1
            if takes_more and not method.startswith("_") and function.__qualname__[0] != "_":
                found.add(f"{name}.{method}")
    return found


def test_each_public_function_is_tried() -> None:
    tried = {*FUNCTIONS, *(f"SoundClient.{name}" for name in SOUND_METHODS), *EXEMPT}
    records = {
        f"{name}." for name in voz.__all__ if hasattr(getattr(voz, name), "__struct_fields__")
    }
    missing = {f for f in public_functions() - tried if not f.startswith(tuple(records))}
    assert missing == set()


def end(result: object) -> None:
    """Do what was only promised."""
    if isinstance(result, MicrophoneUtterances):
        result.close()
    elif isinstance(result, Iterator):
        list(result)
    elif isinstance(result, AsyncIterator):
        asyncio.run(_take(result))


async def _take(result: AsyncIterator[object]) -> None:
    async for _ in result:
        pass


def try_with(call: Call, at: int, wrong: object) -> None:
    function, good = call
    arguments = [*good]
    is_users_own = callable(arguments[at]) and callable(wrong)
    arguments[at] = wrong
    try:
        end(function(*arguments))
    except voz.VozError:
        pass
    except TypeError:  # a function that takes other arguments is the user's own
        if not is_users_own:
            raise


few = settings(
    max_examples=100, suppress_health_check=[*HealthCheck], derandomize=True, database=None
)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_wrong_argument_raises_nothing_but_an_error_of_voz(
    name: str, recognizer: Recognizer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    @few
    @given(wrong=WRONG, place=st.integers(0, 9))
    def tried(wrong: object, place: int) -> None:
        call = FUNCTIONS[name](recognizer)
        try_with(call, place % len(call[1]), wrong)

    try:
        tried()
    finally:
        # Another test may use the same recognizer.
        recognizer.set_false_alarm_rate(voz.Recognition().false_alarms_per_hour)
        recognizer.reload()
        recognizer.expect(())


def test_a_wrong_argument_of_a_sound_is_an_error_of_voz_too() -> None:
    with voz.SoundClient(warn=nothing) as client:

        @few
        @given(wrong=WRONG, place=st.integers(0, 9), name=st.sampled_from([*SOUND_METHODS]))
        def tried(wrong: object, place: int, name: str) -> None:
            good = SOUND_METHODS[name]
            try_with((getattr(client, name), good), place % len(good), wrong)
            client.stop_all()

        tried()


@pytest.mark.parametrize("wrong", [None, "1", 10**400, float("nan"), 1e300, np.zeros(3)])
def test_what_ends_a_motion_ends_it_before_it_complains(wrong: Any) -> None:
    sent: list[voz.Event] = []
    controller = voz.Controller([sent.append], listening=True)
    controller.hear(SAID)
    assert controller.moving
    with pytest.raises(voz.ConfigError):
        controller.zero(wrong)
    assert sent[-1] == voz.Twist(0, 0, 0)
    with pytest.raises(voz.ConfigError):
        controller.stop(wrong, "why")
    assert not controller.moving


def test_a_class_in_place_of_a_robot_is_told_as_that() -> None:
    with pytest.raises(voz.ConfigError, match=r"^Wheels is a class; give a robot, as Wheels\(\)$"):
        voz.Controller(Wheels)  # type: ignore[arg-type]
