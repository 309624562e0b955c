"""What was misheard, and by whose voice."""

from __future__ import annotations

from typing import Any

from voz.apps.evaluation.confusions import confusions
from voz.apps.evaluation.scores import score
from voz.apps.evaluation.tables import main_tables, table_text


def test_each_command_is_counted_by_what_became_of_it(result: Any) -> None:
    clips = [
        result("go back", "go forward", speaker="anne"),
        result("go back", "go forward", speaker="bob"),
        result("go back", "go forward", speaker="anne"),
        result("go back", "go back", speaker="anne"),
        result("go back", "go back?", speaker="anne"),
        result("go back", "fold arm?", speaker="bob"),
        result("go back", speaker="bob"),
        result("stop", "stop", "go back", speaker="bob"),
        result("stop", "stop", "stop", speaker="bob"),
        result("go up", "stop", kind="near-miss"),
        result("stop | go back", "stop", kind="long"),
    ]
    assert [(c.said, c.outcome, c.speakers) for c in confusions(clips)] == [
        ("go back", "as go forward", {"anne": 2, "bob": 1}),
        ("go back", "refused", {"anne": 1, "bob": 1}),
        ("go back", "not heard", {"bob": 1}),
        ("stop", "as go back", {"bob": 1}),
        ("stop", "more than once", {"bob": 1}),
    ]


def test_the_table_has_a_column_for_each_speaker(result: Any) -> None:
    clips = [result("go back", "stop", speaker="anne") for _ in range(2)]
    clips += [result("stop", speaker="bob"), result("stop", "stop", speaker="carol")]
    _, table = main_tables(score(clips), [])
    assert table_text(table).splitlines() == [
        "misheard         clips  anne  bob",
        "go back as stop      2     2     ",
        "stop not heard       1          1",
    ]


def test_the_table_stays_small(result: Any) -> None:
    clips = [result(f"go {n}", speaker=f"s{n % 9}") for n in range(14)]
    clips += [result("stop", "go 1", speaker="s0")]
    _, table = main_tables(score(clips), [])
    assert table.header == ("misheard", "clips", "s0", "s1", "s2", "s3", "s4", "s5", "others")
    assert len(table.rows) == 11
    name, *counts = table.rows[-1]
    assert name == "5 more"
    assert sum(int(row[1]) for row in table.rows) == len(clips)
    assert int(counts[0]) == sum(int(count or 0) for count in counts[1:])


def test_where_nothing_is_misheard_there_is_no_table(result: Any) -> None:
    (table,) = main_tables(score([result("stop", "stop")]), [])
    assert table.header[0] == "commands"
