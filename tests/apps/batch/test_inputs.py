"""Which recordings are meant by files, folders, manifests, lists and addresses."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import FIXTURES

from voz.apps.batch.inputs import find_inputs, parse_shard, shard_of
from voz.errors import ConfigError


def touch(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()


def found(*given: str, glob: str | None = None, listed: tuple[str, ...] = ()) -> list[str]:
    return find_inputs(given, glob, listed).names


def test_a_folder_is_all_recordings_in_it_however_deep(tmp_path: Path) -> None:
    touch(tmp_path, "b.wav", "a/z.FLAC", "a/b/c.mp3", "notes.txt")
    names = [str(tmp_path / name) for name in ("a/b/c.mp3", "a/z.FLAC", "b.wav")]
    assert found(str(tmp_path)) == names
    assert found(str(tmp_path), glob="*") == [str(tmp_path / n) for n in ("b.wav", "notes.txt")]


def test_each_is_taken_once_in_the_order_of_the_names(tmp_path: Path) -> None:
    touch(tmp_path, "b.wav", "a.wav")
    first = str(tmp_path / "b.wav")
    assert found(first, str(tmp_path), first) == [first, str(tmp_path / "a.wav")]


def test_a_list_may_name_anything(tmp_path: Path) -> None:
    touch(tmp_path, "a/b.wav", "c.wav")
    listed = (str(tmp_path / "c.wav"), "", str(tmp_path / "a"), "http://host/d.wav")
    assert found("-", listed=listed)[1:] == [str(tmp_path / "a" / "b.wav"), "http://host/d.wav"]


def test_a_manifest_is_its_recordings_and_what_is_said() -> None:
    inputs = find_inputs([str(FIXTURES / "manifest.tsv")], None, ())
    assert len(inputs.names) == len(inputs.clips) == 180
    assert inputs.names[0] == str(FIXTURES / "commands" / "espeak_gb__fold_arm.flac")


def test_what_is_not_there_is_a_recording_that_cannot_be_read() -> None:
    assert found("none.wav", "x" * 5000) == ["none.wav", "x" * 5000]


def test_a_folder_without_recordings_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="holds no file with the ending of a recording"):
        found(str(tmp_path))


def test_recordings_that_are_left_out_are_named_and_many_counted(tmp_path: Path) -> None:
    touch(tmp_path, "a.wav", "a.webm", "x/b.amr", "c.m4a", "c.m4a.wav", "notes.txt", "d.aac/e.wav")
    inputs = find_inputs([str(tmp_path)], None, ())
    assert inputs.left_out == [tmp_path / "x" / "b.amr"]
    assert find_inputs([str(tmp_path)], "*.wav", ()).left_out_warning is None
    touch(tmp_path, *(f"{number}.mp4" for number in range(9)))
    warning = find_inputs([str(tmp_path)], None, ()).left_out_warning
    assert warning
    named, advice = warning.split("; ")
    assert named.startswith(f"left out, as voz does not read the format: {tmp_path}/0.mp4, ")
    assert named.endswith(f"{tmp_path}/4.mp4 and 5 more")
    assert advice == f"convert it with: ffmpeg -i {tmp_path}/0.mp4 {tmp_path}/0.wav"


def test_a_folder_of_other_formats_alone_is_a_mistake(tmp_path: Path) -> None:
    touch(tmp_path, "a.m4a")
    with pytest.raises(ConfigError, match=r"does not read the format: .*a\.m4a; convert it with"):
        found(str(tmp_path))


@given(st.integers(1, 9), st.integers(0, 40))
def test_shards_are_all_of_it_and_nothing_twice(count: int, names: int) -> None:
    everything = [str(number) for number in range(names)]
    shards = [shard_of(everything, f"{number}/{count}") for number in range(1, count + 1)]
    assert sorted(name for shard in shards for name in shard) == sorted(everything)
    sizes = [len(shard) for shard in shards]
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize("shard", ["", "3", "0/2", "3/2", "a/b", "1/-2", "1/2/3", "²/3"])
def test_what_is_no_shard_is_refused(shard: str) -> None:
    with pytest.raises(ConfigError, match="shard"):
        parse_shard(shard)


def test_a_manifest_keeps_its_columns(tmp_path: Path) -> None:
    (tmp_path / "one.tsv").write_text(
        "file\ttext\tspeaker\tkind\troom\n"
        "a.wav\tgo\tanne\tcommand\thall\nb.wav\tgo\tbob\tcommand\t\n"
    )
    (tmp_path / "two.tsv").write_text(
        "path\ttext\tspeaker\tkind\tstart\tend\tage\n"
        "c.wav\tgo\tanne\tcommand\t1\t2\t31\nc.wav\tstop\tanne\tcommand\t3\t4\t31\n"
    )
    inputs = find_inputs([str(tmp_path / "one.tsv"), str(tmp_path / "two.tsv")], None, ())
    own = ("manifest_file", "manifest_text", "speaker", "kind", "room")
    assert inputs.columns == (*own, "path", "manifest_start", "manifest_end", "age")
    a, b, c = (inputs.manifest[str(tmp_path / name)] for name in ("a.wav", "b.wav", "c.wav"))
    assert dict(a) == dict(zip(own, ["a.wav", "go", "anne", "command", "hall"], strict=True))
    assert "room" not in b
    assert c == {"path": "c.wav", "speaker": "anne", "kind": "command", "age": "31"}
