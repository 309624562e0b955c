"""The journal: wherever it is cut, what is whole is kept; nobody else writes it meanwhile."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.journal import journal_path, open_journal
from voz.apps.batch.outcomes import Outcome, Row, SilentRow, UtteranceRow, failed_outcome
from voz.apps.batch.stamps import Stamp
from voz.errors import ConfigError
from voz.settings import Recognition

HEADER = Header("0.1.0", "print", "commands", "models", Recognition())
NAMES = [f"{number}.wav" for number in range(6)]


def outcome(name: str, kind: int) -> Outcome:
    heard = [UtteranceRow(name, 0.5 * n, 1.0, "go\nbäck", 0.5, True) for n in range(kind)]
    rows: tuple[Row, ...] = tuple(heard) or (SilentRow(name, 2.0),)
    stamp = Stamp(9, "12", "abc") if kind else None
    return failed_outcome(name, f"{name}: bad") if kind == 3 else Outcome(rows, 1.5, 0.25, stamp)


KNOWN = {name: outcome(name, number % 4) for number, name in enumerate(NAMES)}


@given(st.permutations(NAMES), st.floats(0, 1))
def test_wherever_it_is_cut_what_is_whole_is_kept(order: list[str], at: float) -> None:
    """A killed process, or one without power, leaves the file that SQLite writes first cut."""
    with tempfile.TemporaryDirectory() as folder:
        begun, output = f"{folder}/begun.jsonl", f"{folder}/heard.jsonl"
        written = Path(f"{journal_path(begun)}-wal")
        ends = []
        with open_journal(begun, HEADER, NAMES, resume=False) as journal:
            for name in order:
                journal.add(name, KNOWN[name])
                ends.append(written.stat().st_size)
            size = int(at * ends[-1])
            shutil.copy(journal_path(begun), journal_path(output))
            Path(f"{journal_path(output)}-wal").write_bytes(written.read_bytes()[:size])
        whole = [name for name, end in zip(order, ends, strict=True) if end <= size]
        with open_journal(output, HEADER, NAMES, resume=True) as journal:
            missing = [NAMES[number] for number in journal.missing()]
            assert sorted([*missing, *whole]) == NAMES
            for name in missing:
                journal.add(name, KNOWN[name])
            assert list(journal.outcomes()) == [KNOWN[name] for name in NAMES]


def test_a_recording_gets_another_stamp_and_keeps_its_rows(tmp_path: Path) -> None:
    output, later = str(tmp_path / "heard.jsonl"), Stamp(9, "13", "abc")
    with open_journal(output, HEADER, NAMES, resume=False) as journal:
        for name in NAMES[1:]:
            journal.add(name, KNOWN[name])
        journal.set_stamps([(2, later)])
    with open_journal(output, HEADER, NAMES, resume=True) as journal:
        stamps = {number: each.stamp for number, each in journal.stamps()}
        assert stamps == {n: KNOWN[NAMES[n]].stamp for n in range(1, 6)} | {2: later}
        journal.add(NAMES[0], KNOWN[NAMES[0]])
        outcomes = list(journal.outcomes())
    assert [o.rows for o in outcomes] == [KNOWN[name].rows for name in NAMES]
    assert outcomes[2].stamp == later


def test_what_failed_can_be_asked_for_again(tmp_path: Path) -> None:
    output = str(tmp_path / "heard.jsonl")
    with open_journal(output, HEADER, NAMES, resume=False) as journal:
        for name in NAMES:
            journal.add(name, KNOWN[name])
    with open_journal(output, HEADER, NAMES, resume=True) as journal:
        assert journal.missing() == []
        assert journal.missing(failed=True) == [3]
        journal.add(NAMES[3], KNOWN[NAMES[1]])
        assert journal.missing(failed=True) == []


def test_input_that_grows_is_missing_and_what_is_gone_is_not_asked_for(tmp_path: Path) -> None:
    output = str(tmp_path / "heard.jsonl")
    with open_journal(output, HEADER, NAMES[:2], resume=False) as journal:
        for name in NAMES[:2]:
            journal.add(name, KNOWN[name])
    with open_journal(output, HEADER, [NAMES[4], NAMES[1]], resume=True) as journal:
        assert journal.missing() == [0]


def test_two_runs_on_one_output_are_refused(tmp_path: Path) -> None:
    output = str(tmp_path / "heard.jsonl")
    with (
        open_journal(output, HEADER, NAMES, resume=False),
        pytest.raises(ConfigError, match="is being written by another run"),
        open_journal(output, HEADER, NAMES, resume=True),
    ):
        pass


def test_a_run_that_has_not_ended_is_not_begun_anew_by_mistake(tmp_path: Path) -> None:
    output = str(tmp_path / "heard.jsonl")
    with open_journal(output, HEADER, NAMES, resume=False):
        pass
    with (
        pytest.raises(ConfigError, match="continue it with --resume"),
        open_journal(output, HEADER, NAMES, resume=False),
    ):
        pass


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fingerprint": "another", "commands": "x"}, "another command list"),
        ({"fingerprint": "another", "models": "x"}, "other models"),
        ({"fingerprint": "another", "settings": Recognition(threshold=0.5)}, "other settings"),
        ({"fingerprint": "another", "voz": "9"}, "another version of voz"),
        ({"words": True}, "was started with another --words or --best"),
        ({"best": 3}, "was started with another --words or --best"),
        ({"shard": "2/3"}, "was started with shard none"),
        ({"drive": "rules"}, "was started with no --drive"),
    ],
)
def test_what_was_begun_otherwise_is_refused(
    tmp_path: Path, change: dict[str, object], said: str
) -> None:
    output = str(tmp_path / "heard.jsonl")
    with open_journal(output, HEADER, NAMES, resume=False):
        pass
    with (
        pytest.raises(ConfigError, match=said),
        open_journal(output, replace(HEADER, **change), NAMES, resume=True),
    ):
        pass


def test_what_is_no_journal_is_refused(tmp_path: Path) -> None:
    output = str(tmp_path / "heard.jsonl")
    journal_path(output).write_text("mine\n")
    with (
        pytest.raises(ConfigError, match="is not a journal"),
        open_journal(output, HEADER, NAMES, resume=True),
    ):
        pass
    assert journal_path(output).read_text() == "mine\n"
