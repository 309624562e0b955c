from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import FIXTURES

from voz.apps.recordings.manifest import (
    ManifestLine,
    join_lines,
    parse_lines,
    parse_records,
    read_manifest,
    read_manifests,
    set_name,
)
from voz.errors import VozError

GOOD = "path\ttext\tspeaker\tkind\tcondition\na.wav\t Go  Back\tann\tcommand\tus\n"


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_a_manifest_with_all_columns(tmp_path: Path) -> None:
    (clip,) = read_manifest(write(tmp_path / "quiet.tsv", GOOD))
    assert (clip.set, clip.file, clip.path) == ("quiet", "a.wav", tmp_path / "a.wav")
    assert (clip.text, clip.speaker, clip.kind) == ("go back", "ann", "command")
    assert clip.condition == "us"


def test_the_other_names_of_columns_and_what_may_be_missing(tmp_path: Path) -> None:
    text = "\ufefffile\tvoice\tlicence\tkind\ttext\r\n\r\n/x/hum.wav\t\tfree\tnoise\t\r\n"
    (clip,) = read_manifest(write(tmp_path / "manifest.tsv", text))
    assert (clip.set, clip.path) == (tmp_path.name, Path("/x/hum.wav"))
    assert (clip.speaker, clip.condition, clip.text) == ("/x/hum.wav", "all", "")


def test_the_manifest_of_the_fixtures() -> None:
    clips = read_manifests([FIXTURES / "manifest.tsv"] * 2)
    assert {clip.kind for clip in clips} == {"command", "near-miss", "long"}
    assert {clip.set for clip in clips} == {"audio_fixtures"}
    assert all(clip.path.is_file() for clip in clips)


def test_lines_of_a_stream_say_where_in_it_they_are(tmp_path: Path) -> None:
    text = "path\tstart\tend\ttext\tspeaker\tkind\n"
    text += "a.wav\t0\t1.5\tstop\tann\tcommand\na.wav\t\t\tgo back\tann\tcommand\n"
    path = write(tmp_path / "streams.tsv", text)
    stretch, whole = read_manifest(path, streams=True)
    assert (stretch.start, stretch.end) == (0, 1.5)
    assert (whole.start, whole.end) == (None, None)
    with pytest.raises(VozError, match=r"streams.tsv:2: is a stretch of a recording"):
        read_manifest(path)


@pytest.mark.parametrize(
    ("start", "end"),
    [("1", ""), ("", "1"), ("2", "1"), ("1", "1"), ("-1", "1"), ("nan", "2"), ("0", "inf")],
)
def test_a_stretch_that_is_none_is_one_line(start: str, end: str, tmp_path: Path) -> None:
    text = f"path\tstart\tend\ttext\tspeaker\tkind\na\t{start}\t{end}\tstop\tann\tcommand\n"
    with pytest.raises(VozError, match=r"bad.tsv:2: begins at .* write both in seconds"):
        read_manifest(write(tmp_path / "bad.tsv", text), streams=True)


def test_a_set_is_named_after_its_file_or_folder() -> None:
    assert set_name(Path("/data/dev/manifest.tsv")) == "dev"
    assert set_name(Path("/data/dev/some.tsv")) == "some"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "bad.tsv:1: has no column path or file"),
        ("path\ttext\tkind\n", "bad.tsv:1: has no column speaker or voice"),
        (GOOD.splitlines()[0], "bad.tsv: lists no recording"),
        (GOOD + "b.wav\tstop\tann\n", "bad.tsv:3: has 3 fields and the header 5"),
        (GOOD + "\nb.wav\tstop\tann\tsong\tus\n", 'bad.tsv:4: invalid kind "song"; use one of'),
        (GOOD + "\tstop\tann\tcommand\tus\n", "bad.tsv:3: names no file"),
        (GOOD + "\0.wav\tstop\tann\tcommand\tus\n", "bad.tsv:3: names no file"),
        (GOOD + "b.wav\t\tann\tcommand\tus\n", "bad.tsv:3: has no text"),
    ],
)
def test_a_bad_manifest_is_one_line_that_says_where(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(VozError) as caught:
        read_manifest(write(tmp_path / "bad.tsv", text))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_no_manifest_at_all(tmp_path: Path) -> None:
    (tmp_path / "sound.wav").write_bytes(b"RIFF\xff\xfe")
    for path, said in [("none.tsv", "cannot be read"), ("sound.wav", "UTF-8"), (".", "read")]:
        with pytest.raises(VozError, match=said):
            read_manifest(tmp_path / path)


FIELD = st.text(st.characters(exclude_characters="\t\n\r", exclude_categories=["Cs"]))
ROWS = st.lists(st.lists(FIELD, min_size=1).filter(lambda fields: "".join(fields).strip()))


@given(ROWS)
def test_what_is_written_is_read_again(rows: list[list[str]]) -> None:
    assert [row.fields for row in parse_lines(join_lines(rows))] == rows


@given(ROWS)
def test_ends_of_lines_may_be_others_and_the_last_be_missing(rows: list[list[str]]) -> None:
    text = join_lines(rows)
    assert parse_lines(text.replace("\n", "\r\n")) == parse_lines(text)
    assert parse_lines(text.removesuffix("\n")) == parse_lines(text)


def test_empty_lines_are_left_out_and_counted() -> None:
    assert parse_lines("a\tb\n\n  \n\t\nc\n") == [
        ManifestLine(1, ["a", "b"]),
        ManifestLine(5, ["c"]),
    ]
    assert parse_lines("") == []


def test_records_have_the_names_of_the_columns() -> None:
    records = parse_records("file\ttext\na.wav\tgo back\nb.wav\t\n")
    assert records == [{"file": "a.wav", "text": "go back"}, {"file": "b.wav", "text": ""}]
