"""No value from outside its range gets into a record, by whatever way."""

from __future__ import annotations

import importlib
import math
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

import voz
from voz.apps.web.control_api import decode_json
from voz.apps.web.page_messages import Alarms
from voz.config import Config, load_config, overridden
from voz.control.motion import Motion, apply_step
from voz.control.safety import apply_safety
from voz.control.steps import Step
from voz.errors import ConfigError, VozError
from voz.records import CheckedRecord
from voz.settings import Recognition, Safety, Section

ENTRIES = Path(voz.__file__).parent

SENTENCE = {"t": 0.0, "text": "stop", "confidence": 1.0}
MODEL = {"fitted_on": [], "intercept": 0.0, "weights": {}, "alarms": 1.0, "alarm_exponent": 1.0}
NEEDED: dict[str, dict[str, Any]] = {
    "Alternative": {"text": "stop", "confidence": 1.0},
    "Attention": {"t": 0.0, "awake": True},
    "CallFunction": {"t": 0.0, "function": "arm:wave"},
    "MissRate": {"alarms": 1.0, "missed": 0.1},
    "ProgramEnded": {"t": 0.0, "name": "arm:wave"},
    "Model": MODEL,
    "Models": {"with_network": MODEL, "without_network": MODEL},
    "Partial": SENTENCE,
    "Play": {"t": 0.0, "sound": "beep.wav"},
    "PossibleCommand": {"text": "go back", "command": "go back"},
    "Publish": {"t": 0.0, "topic": "lamp", "value": 1},
    "Reply": {"t": 0.0, "text": "hello"},
    "StartProgram": {"t": 0.0, "program": ("true",)},
    "SelectedObject": {"t": 0.0, "value": 1},
    "SpokenWord": {"word": "stop", "start": 0.0, "end": 0.5},
    "Step": {"drive": 0.1},
    "Twist": {"t": 0.0, "linear": 0.1, "angular": 0.0},
    "Utterance": {**SENTENCE, "accepted": True, "start": 0.0, "end": 0.0, "source": "text"},
    "Notice": {"t": 0.0, "text": "lost"},
}
"""What a record needs besides the field that is looked at, where not all have defaults."""

MEASURED = ("linear", "angular", "above")
"""What is reported as it was found: the velocity in a message, a level above silence."""

NUMBERS = st.one_of(
    st.floats(),
    st.floats(-2, 2),
    st.integers(-3, 5000),
    st.sampled_from([math.nan, math.inf, -math.inf, 0, -0.0, -1, 7, 1e300, 10**400, 2**31, True]),
)
VALUES = st.one_of(NUMBERS, st.none(), st.text(max_size=5), st.lists(NUMBERS, max_size=5))


def kinds(base: type[CheckedRecord] = CheckedRecord) -> Iterator[type[CheckedRecord]]:
    for kind in base.__subclasses__():
        yield kind
        yield from kinds(kind)


def modules_with_limits() -> list[str]:
    """All modules in which a limit is declared."""
    found = (p for p in ENTRIES.rglob("*.py") if "msgspec.Meta(" in p.read_text())
    return [".".join(("voz", *path.relative_to(ENTRIES).with_suffix("").parts)) for path in found]


for module in modules_with_limits():
    importlib.import_module(module)

RECORDS = [k for k in kinds() if k is not Section and k.__module__.startswith("voz.")]


def outcome(make: Callable[[], object]) -> object:
    """What is made, or the words in which it is refused; without its place, which differs."""
    try:
        return make()
    except (VozError, msgspec.ValidationError) as error:
        return str(error).partition(" - at ")[0]


def numbers_in(value: object) -> Iterator[float]:
    if isinstance(value, dict):
        value = [*value.values()]
    if isinstance(value, list | tuple):
        for each in value:
            yield from numbers_in(each)
    elif isinstance(value, int | float):
        yield value


@pytest.mark.parametrize("kind", RECORDS, ids=lambda kind: kind.__name__)
@given(st.data())
def test_a_constructor_takes_what_a_file_may_hold_and_refuses_the_rest_in_its_words(
    kind: type[CheckedRecord], data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from(kind.__struct_fields__))
    fields = {**NEEDED.get(kind.__name__, {}), name: data.draw(VALUES)}
    made = outcome(lambda: kind(**fields))
    assert made == outcome(lambda: msgspec.convert({**tagged(kind), **fields}, kind))
    if isinstance(made, kind):
        fields = {k: v for k, v in msgspec.to_builtins(made).items() if k not in MEASURED}
        assert all(abs(number) < math.inf for number in numbers_in(fields))
        assert made == replace(made)


def tagged(kind: type[CheckedRecord]) -> dict[str, str]:
    tag = kind.__struct_config__.tag
    return {"type": str(tag)} if tag else {}


def test_every_record_with_limits_is_among_them() -> None:
    """But for what a page sends, which is made from JSON alone: that has its own test."""
    sections = {type(value) for value in map(Config().__getattribute__, Config.__struct_fields__)}
    assert {kind for kind in sections if issubclass(kind, msgspec.Struct)} <= set(RECORDS)
    public = {vars(voz).get(name) or getattr(voz, name) for name in voz.__all__}
    public = {kind for kind in public if isinstance(kind, type)}
    assert {kind for kind in public if issubclass(kind, msgspec.Struct)} <= set(RECORDS)
    for name in modules_with_limits():
        if name != "voz.apps.web.page_messages":
            own = vars(importlib.import_module(name)).values()
            assert any(kind in RECORDS or kind is CheckedRecord for kind in own), name


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Safety(max_linear=-1), "Expected `float` >= 0.0 - at `Safety.max_linear`"),
        (lambda: Safety(max_linear=math.nan), "Expected `float` >= 0.0 - at `Safety.max_linear`"),
        (lambda: Safety(max_linear=math.inf), "Expected `float` <= 1000000.0 - at `Safety.max_lin"),
        (lambda: Safety(max_linear="1"), "Expected `float`, got `str` - at `Safety.max_linear`"),  # type: ignore[arg-type]
        (lambda: Safety(enabled="no"), "Expected `bool`, got `str` - at `Safety.enabled`"),  # type: ignore[arg-type]
        (lambda: replace(Safety(), max_angular=-1), "Expected `float` >= 0.0 - at `Safety.max_ang"),
        (
            lambda: Recognition(false_alarms_per_hour=-3),
            "Expected `float` > 0.0 - at `Recognition.false_alarms_per_hour`",
        ),
        (
            lambda: Recognition(threshold=7),
            "Expected `float` <= 1.0 - at `Recognition.threshold`",
        ),
        (
            lambda: Recognition(never_missed="stop"),  # type: ignore[arg-type]
            "Expected `array`, got `str` - at `Recognition.never_missed`",
        ),
        (lambda: Config(robot="console"), "Expected `array`, got `str` - at `Config.robot`"),  # type: ignore[arg-type]
        (lambda: Step(drive=0), "`drive` is 0; to end a motion write stop = true"),
        (lambda: Step(drive=math.nan), "Expected `float` >= -1000.0 - at `Step.drive`"),
        (
            lambda: voz.Utterance(0, "go", 1, True, 0, 0, "text", slots={"way": 10**400}),
            "Expected `int` <= 9223372036854775807 - at `Utterance.slots[...]`",
        ),
        (lambda: voz.BuiltinSound(9), "there is no built-in sound 9; give 1 to 5"),
        (lambda: voz.Controller([], 0.3), "Expected `Safety`, got `float` - at `safety`"),  # type: ignore[arg-type]
        (
            lambda: voz.Controller([], Safety(), "yes"),
            "Expected `bool`, got `str` - at `listening`",
        ),  # type: ignore[arg-type]
        (lambda: voz.SoundClient(voice=3), "Expected `str`, got `int` - at `voice`"),  # type: ignore[arg-type]
        (lambda: voz.SoundClient(blocking="no"), "Expected `bool`, got `str` - at `blocking`"),  # type: ignore[arg-type]
        (lambda: voz.load(settings=0.3), "Expected `Recognition`, got `float` - at `settings`"),  # type: ignore[arg-type]
        (lambda: voz.load(profile=3), "Expected `str`, got `int` - at `profile`"),  # type: ignore[arg-type]
    ],
)
def test_what_a_program_gives_is_refused_in_the_words_of_the_file(
    make: Callable[[], object], told: str
) -> None:
    with pytest.raises(VozError) as caught:
        make()
    assert str(caught.value).startswith(told)


def test_numbers_of_numpy_and_lists_are_as_good_as_those_of_python() -> None:
    made = Safety(max_linear=np.float32(0.25), max_angular=np.int64(1))  # type: ignore[arg-type]
    assert repr(made) == repr(Safety(max_linear=0.25, max_angular=1.0))
    assert Recognition(never_missed=["stop"]).never_missed == ("stop",)  # type: ignore[arg-type]
    utterance = voz.Utterance(0, "go", 1, False, 0, 1, "text", between=["go", "stop"])  # type: ignore[arg-type]
    assert utterance.between == ("go", "stop")


@given(NUMBERS, st.floats(-1000, 1000).filter(bool))
def test_no_limit_lets_a_robot_drive_faster_or_the_other_way(limit: Any, velocity: float) -> None:
    try:
        safety = Safety(max_linear=limit, max_angular=limit)
    except ConfigError:
        return
    for step in (Step(drive=velocity), Step(turn=velocity)):
        driven = apply_safety(step, Motion(), apply_step(Motion(), step), safety).velocities()
        assert all(abs(v) <= limit + 1e-9 and v * velocity >= 0 for v in driven)


def toml(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return repr(value).lower() if isinstance(value, bool | int | float) else f"'{value}'"


TABLES = [
    (name, kind)
    for name in Config.__struct_fields__
    if issubclass(kind := type(getattr(Config(), name)), CheckedRecord)
]
FIELDS = [(table, kind, name) for table, kind in TABLES for name in kind.__struct_fields__]
WRITTEN = st.one_of(
    NUMBERS,
    st.sampled_from(["", "stop", "grammar", "a b"]),
    st.lists(st.floats(-2, 5), max_size=5),
)


@given(st.sampled_from(FIELDS), WRITTEN)
def test_voz_toml_an_option_and_a_constructor_take_the_same(
    field: tuple[str, type[CheckedRecord], str], value: object
) -> None:
    table, kind, name = field
    made = outcome(lambda: Config(**{table: kind(**{name: value})}))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "voz.toml"
        path.write_text(f"[{table}]\n{name} = {toml(value)}\n")
        read = outcome(lambda: load_config(path))
    optional = outcome(lambda: overridden(Config(), {table: {name: value}}))
    if isinstance(made, Config):
        assert read == made
        assert optional == overridden(made, {})
    else:
        assert read == f"{path}: {made}"
        assert optional == f"an option cannot be used: {made}"


@given(st.one_of(NUMBERS, st.text(max_size=5)))
def test_what_a_page_sends_is_in_the_range_of_the_setting(value: object) -> None:
    try:
        sent = msgspec.json.encode({"page": "p", "alarms": value})
    except (UnicodeEncodeError, OverflowError):
        return
    taken = decode_json(sent, Alarms)
    made = outcome(lambda: Recognition(false_alarms_per_hour=value))  # type: ignore[arg-type]
    if taken is None:
        assert not isinstance(made, Recognition)
    else:
        assert made == Recognition(false_alarms_per_hour=taken.alarms)
