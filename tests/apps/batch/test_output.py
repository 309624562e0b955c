"""Outputs of shards make the one that a single run would have made."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import TABLE_FORMATS, write_output
from voz.apps.batch.outcomes import Row, SilentRow
from voz.apps.batch.output import merge
from voz.errors import ConfigError
from voz.settings import Recognition

HEADER = Header("0.1.0", "print", "commands", "models", Recognition(), columns=("room",))
ROWS: list[Row] = [
    SilentRow(f"{n}.wav", float(n), {"room": f"hall {n}"} if n else {}) for n in range(3)
]


def shard(path: Path, number: int, **others: tuple[str, ...]) -> str:
    header = replace(HEADER, shard=f"{number}/5", inputs="names", **others)
    write_output(path, header, ROWS[number - 1 :: 5])
    return str(path)


@pytest.mark.parametrize("ending", TABLE_FORMATS)
def test_columns_of_manifests_stay_and_shards_may_be_empty(tmp_path: Path, ending: str) -> None:
    shards = [shard(tmp_path / f"{number}{ending}", number) for number in range(1, 6)]
    assert merge(shards, str(tmp_path / f"merged{ending}")) == 3
    write_output(tmp_path / f"whole{ending}", HEADER, ROWS)
    merged, whole = (tmp_path / f"{name}{ending}" for name in ("merged", "whole"))
    assert merged.read_bytes() == whole.read_bytes()


def test_another_manifest_is_refused(tmp_path: Path) -> None:
    shards = [shard(tmp_path / f"{number}.csv", number) for number in range(1, 5)]
    shards.append(shard(tmp_path / "5.csv", 5, columns=("hall",)))
    with pytest.raises(ConfigError, match="was made with another manifest than"):
        merge(shards, str(tmp_path / "merged.csv"))


@pytest.mark.parametrize("number", [1, 5])
def test_a_shard_with_recordings_that_others_should_have_is_refused(
    tmp_path: Path, number: int
) -> None:
    shards = [shard(tmp_path / f"{n}.csv", n) for n in range(1, 6)]
    header = replace(HEADER, shard=f"{number}/5", inputs="names")
    write_output(tmp_path / f"{number}.csv", header, ROWS)
    with pytest.raises(ConfigError, match=f"shard {number}: has more recordings than another"):
        merge(shards, str(tmp_path / "merged.csv"))
    assert not (tmp_path / "merged.csv").exists()
