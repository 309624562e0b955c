"""`voz decode --out`: nothing is lost, however a run ends; and the shards of many make one."""

from __future__ import annotations

import os
import pty
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, nullcontext, suppress
from pathlib import Path

import numpy as np
import pytest
import soundfile
from calls import HANGS, VOZ, Result, in_process
from programs import wait_until
from recordings import FIXTURES

from voz.apps.batch.executors import InlineExecutor
from voz.cli import main

pytestmark = pytest.mark.slow

COUNT = 12
ALL_KNOWN = f"{COUNT} recordings ({COUNT} were known)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    commands = sorted((FIXTURES / "commands").glob("*.flac"))[:: 112 // COUNT][:COUNT]
    for number, path in enumerate(commands):
        shutil.copy(path, folder / f"{number:02}.flac")
    (folder / "07.flac").write_bytes(b"")
    soundfile.write(folder / "09.flac", [0.0] * 16000, 16000)
    return folder


Decode = Callable[..., Result]


def by_process(out: Path, folder: Path, *more: object) -> Result:
    """Decode as users do: by a program, whose recordings are decoded in another process."""
    return in_process("decode", folder, "--no-network", "--jobs", "1", "--out", out, *more)


def decode_here(out: Path, folder: Path, *more: object) -> None:
    """Decode in this process for all tests of the module."""
    given = ["decode", folder, "--no-network", "--out", out, *more]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(signal, "signal", lambda *_: None)  # pytest's own stay
        patched.setattr(
            "voz.apps.batch.batch_decoder.process_executor",
            lambda setup, _: nullcontext(InlineExecutor(setup)),
        )
        assert main([str(each) for each in given]) in (0, 3)


@pytest.fixture
def decode(voz: Decode, inline: None) -> Decode:
    """Decode in this process, which makes the same file: `known` is made by a program."""
    return lambda out, folder, *more: voz("decode", folder, "--no-network", "--out", out, *more)


@pytest.fixture(scope="module")
def known(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What one run that nobody disturbs makes, by the ending of its name."""
    place = tmp_path_factory.mktemp("known")
    result = by_process(place / "heard.jsonl", folder)
    assert result.code == 3
    assert f"{COUNT} recordings" in result.err
    assert "1 recordings with nothing in them, 1 that could not be read" in result.err
    for ending in (".csv", ".parquet"):
        decode_here(place / f"heard{ending}", folder)
    endings = (".jsonl", ".csv", ".parquet")
    return {ending: (place / f"heard{ending}").read_bytes() for ending in endings}


def begun(out: Path, folder: Path, *more: object) -> subprocess.Popen[str]:
    """Begin a run by two processes; the file is to be that of one."""
    given = ["decode", folder, "--no-network", "--jobs", "2", "--out", out, *more]
    command = [*VOZ, *map(str, given)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


@pytest.fixture(scope="module")
def silence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("silence") / "silence.flac"
    soundfile.write(path, np.zeros(600 * 16000, np.int16), 16000)
    return path


def kept_in(journal: Path) -> list[str]:
    """The recordings in a journal, whose run may still have it locked."""
    with tempfile.TemporaryDirectory() as place:
        for path in journal.parent.glob(f"{journal.name}*"):
            with suppress(FileNotFoundError):  # the run has just ended
                shutil.copy(path, place)
        with closing(sqlite3.connect(Path(place) / journal.name)) as copy:
            try:
                return [file for (file,) in copy.execute("SELECT file FROM recording")]
            except sqlite3.DatabaseError:  # it has just begun, or was just being written
                return []


@contextmanager
def going_on(
    out: Path, folder: Path, silence: Path
) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Begin a run, and suspend it before its last, long recording; gives its journal too."""
    last = folder / "99.flac"
    last.hardlink_to(silence)
    journal = out.with_name(f"{out.name}.journal")
    try:
        with begun(out, folder) as program:
            wait_until(lambda: len(kept_in(journal)) >= 5)
            program.send_signal(signal.SIGSTOP)
            try:
                yield program, journal
            finally:
                program.send_signal(signal.SIGCONT)
    finally:
        last.unlink()  # the other tests have the same folder


def test_a_run_that_is_killed_again_and_again_makes_the_same_file(
    decode: Decode, folder: Path, known: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / "heard.jsonl"
    moments = random.Random(1)
    for longest in (0.5, 1.0, 1.5, 2.0):
        with begun(out, folder, "--resume") as program:
            timer = threading.Timer(moments.uniform(0.2, longest), program.kill)
            timer.start()
            program.communicate()
            timer.cancel()
    result = decode(out, folder, "--resume")
    assert result.code == 3
    assert out.read_bytes() == known[".jsonl"]
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [out.name, f"{out.name}.recordings"]


def test_ctrl_c_says_how_to_go_on(
    decode: Decode, folder: Path, known: dict[str, bytes], silence: Path, tmp_path: Path
) -> None:
    out = tmp_path / "heard.csv"
    with going_on(out, folder, silence) as (program, journal):
        program.send_signal(signal.SIGINT)
        program.send_signal(signal.SIGCONT)
        _, told = program.communicate()
    assert program.returncode == 128 + signal.SIGINT
    assert told.splitlines() == [
        f"the results so far are kept in {journal}: continue with --resume"
    ]
    assert not out.exists()
    assert decode(out, folder).complaint.endswith("or start again with --overwrite")
    result = decode(out, folder, "--resume")
    assert "were known" in result.err
    assert out.read_bytes() == known[".csv"]


def test_input_that_grows_is_taken_up_and_what_failed_is_tried_again(
    decode: Decode, folder: Path, tmp_path: Path
) -> None:
    some, out = tmp_path / "some", tmp_path / "heard.parquet"
    shutil.copytree(folder, some)
    (some / "00.flac").unlink()
    (some / "07.flac").write_bytes(b"bad")
    assert decode(out, some).code == 3
    shutil.copy(folder / "00.flac", some)
    assert f"{COUNT} recordings ({COUNT - 1} were known)" in decode(out, some, "--resume").err
    again = decode(out, some, "--retry-failed")
    assert again.code == 3
    assert f"{COUNT} recordings ({COUNT - 1} were known)" in again.err
    fresh = tmp_path / "fresh.parquet"
    decode(fresh, some)
    assert out.read_bytes() == fresh.read_bytes()


def kept_by_a_kill(out: Path, folder: Path, silence: Path) -> set[str]:
    """Kill a run in its midst; gives what it has decoded until then."""
    with going_on(out, folder, silence) as (program, journal):
        program.kill()
        program.communicate()
    return {Path(file).name for file in kept_in(journal)}


@pytest.mark.parametrize("killed", [True, False])
def test_what_changed_is_decoded_again_and_named(
    decode: Decode, folder: Path, silence: Path, tmp_path: Path, killed: bool
) -> None:
    some, out = tmp_path / "some", tmp_path / "heard.jsonl"
    shutil.copytree(folder, some)
    if killed:
        known = sorted(kept_by_a_kill(out, some, silence) - {"07.flac", "09.flac"})
    else:
        decode(out, some)
        known = ["03.flac", "07.flac", "08.flac"]
    shutil.copy(folder / "10.flac", some / known[0])
    shutil.copy(folder / "11.flac", some / known[1])
    os.utime(some / known[2])
    result = decode(out, some, "--resume")
    named = ", ".join(str(some / name) for name in known[:2])
    assert f"changed since, decoded again: {named}\n" in result.err
    if not killed:
        assert f"{COUNT} recordings ({COUNT - 2} were known)" in result.err
    fresh = tmp_path / "fresh.jsonl"
    decode(fresh, some)
    assert out.read_bytes() == fresh.read_bytes()
    assert ALL_KNOWN in decode(out, some, "--resume").err


def test_an_output_without_what_its_recordings_were_like_says_that_all_are_taken(
    decode: Decode, folder: Path, known: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / "heard.jsonl"
    decode(out, folder)
    before = (tmp_path / "heard.jsonl.recordings").read_text()
    (tmp_path / "heard.jsonl.recordings").unlink()
    result = decode(out, folder, "--resume")
    assert f"{out}: has no .recordings file of its own" in result.err
    assert ALL_KNOWN in result.err
    assert "has no .recordings file" not in decode(out, folder, "--resume").err
    # Of another output it says nothing.
    out.write_bytes(b"".join(known[".jsonl"].splitlines(keepends=True)[:-1]))
    assert "has no .recordings file" in decode(out, folder, "--resume").err
    assert out.read_bytes() == known[".jsonl"]
    (tmp_path / "heard.jsonl.recordings").write_text(before[:-20])
    assert "heard.jsonl.recordings: is damaged" in decode(out, folder, "--resume").complaint


def test_what_is_gone_keeps_its_results(decode: Decode, folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "00.flac", tmp_path)
    out, listed = tmp_path / "heard.jsonl", tmp_path / "00.flac"
    assert decode(out, listed).code == 0
    before = out.read_bytes()
    listed.unlink()
    assert decode(out, listed, "--resume").code == 0
    assert out.read_bytes() == before


def test_a_finished_output_is_replaced_only_if_asked(
    decode: Decode, folder: Path, tmp_path: Path
) -> None:
    out, one = tmp_path / "heard.jsonl", folder / "00.flac"
    assert decode(out, one).code == 0
    before = out.read_bytes()
    complaint = decode(out, folder / "01.flac").complaint
    assert complaint == (
        f"voz: {out}: is there already; continue it with --resume, replace it by --overwrite, "
        "or name another file"
    )
    assert out.read_bytes() == before
    assert decode(out, folder / "01.flac", "--overwrite").code == 0
    assert b"01.flac" in out.read_bytes()
    assert b"00.flac" not in out.read_bytes()
    (tmp_path / "empty.csv").touch()
    assert decode(tmp_path / "empty.csv", one).code == 0


def test_an_unfinished_run_is_begun_again_only_if_asked(
    decode: Decode, folder: Path, silence: Path, tmp_path: Path
) -> None:
    out = tmp_path / "heard.jsonl"
    kept_by_a_kill(out, folder, silence)
    assert "has an unfinished run" in decode(out, folder / "00.flac").complaint
    result = decode(out, folder / "00.flac", "--overwrite")
    assert result.err.startswith(f"written: {out}, 1 recordings\n")
    journal = tmp_path / "heard.jsonl.journal"
    journal.write_text("mine\n")
    assert "is not a journal" in decode(out, folder / "00.flac", "--overwrite").complaint
    assert journal.read_text() == "mine\n"


def test_what_changed_since_its_shard_was_made_is_decoded_again(
    decode: Decode, voz: Decode, folder: Path, tmp_path: Path
) -> None:
    some, out = tmp_path / "some", tmp_path / "heard.csv"
    shutil.copytree(folder, some)
    made = shards(decode, some, tmp_path, 2)
    assert voz("merge", *made, "--out", out).code == 0
    shutil.copy(folder / "10.flac", some / "03.flac")
    result = decode(out, some, "--resume")
    assert f"changed since, decoded again: {some / '03.flac'}\n" in result.err
    assert f"{COUNT} recordings ({COUNT - 1} were known)" in result.err
    made[1].with_name(f"{made[1].name}.recordings").unlink()
    assert voz("merge", *made, "--out", out, "--overwrite").code == 0
    assert "has no .recordings file" in decode(out, some, "--resume").err


def test_merged_shards_replace_nothing_unless_asked(
    decode: Decode, voz: Decode, folder: Path, tmp_path: Path
) -> None:
    made, out = shards(decode, folder / "00.flac", tmp_path, 1), tmp_path / "whole.jsonl"
    out.write_text("mine")
    assert f"{out}: is there already; replace" in voz("merge", *made, "--out", out).complaint
    assert out.read_text() == "mine"
    assert voz("merge", *made, "--out", out, "--overwrite").code == 0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--overwrite",), "name it with --out"),
        (("--overwrite", "--resume", "--out", "x.jsonl"), "leave it out to continue"),
        (
            ("--overwrite", "--retry-failed", "--out", "x.jsonl"),
            "leave it out to continue",
        ),
    ],
)
def test_what_is_to_be_replaced_must_be_clear(
    voz: Decode, folder: Path, given: tuple[str, ...], said: str
) -> None:
    assert said in voz("decode", folder, *given).complaint


def test_other_settings_are_refused(decode: Decode, folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "heard.jsonl"
    decode(out, folder, "--glob", "0*")
    before = out.read_bytes()
    complaint = decode(out, folder, "--resume", "--threshold", "0.5").complaint
    assert f"{out}: was started with other settings" in complaint
    assert out.read_bytes() == before


@pytest.fixture(scope="module")
def thirds(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the three shards of all recordings."""
    place = tmp_path_factory.mktemp("thirds")
    shards(decode_here, folder, place, 3)
    return place


def copied(thirds: Path, place: Path) -> list[Path]:
    shutil.copytree(thirds, place, dirs_exist_ok=True)
    return [place / f"heard-{number}.jsonl" for number in (1, 2, 3)]


def shards(decode: Callable[..., object], folder: Path, place: Path, count: int) -> list[Path]:
    made = []
    for number in range(1, count + 1):
        out = place / f"heard-{number}.jsonl"
        decode(out, folder, "--shard", f"{number}/{count}")
        made.append(out)
    return made


def test_shards_merged_are_the_output_of_one_run(
    voz: Decode, thirds: Path, known: dict[str, bytes], tmp_path: Path
) -> None:
    made = copied(thirds, tmp_path)
    for ending, whole in known.items():
        out = tmp_path / f"heard{ending}"
        result = voz("merge", *made[::-1], "--out", out)
        assert (result.code, result.err) == (0, f"written: {out}, {COUNT} recordings\n")
        assert out.read_bytes() == whole


def test_what_is_no_whole_is_not_merged(
    decode: Decode, voz: Decode, folder: Path, thirds: Path, tmp_path: Path
) -> None:
    one, two, three = copied(thirds, tmp_path)
    out = tmp_path / "heard.jsonl"

    def complaint(*given: Path) -> str:
        return voz("merge", *given, "--out", out).complaint

    assert "shard 2/3: is missing" in complaint(one, three)
    assert "named twice" in complaint(one, two, three, two)
    shutil.copy(one, copy := tmp_path / "copy.jsonl")
    assert "named twice" in complaint(one, two, three, copy)
    other = tmp_path / "other.jsonl"
    decode(other, folder, "--shard", "2/3", "--threshold", "0.5")
    assert "was made with other settings" in complaint(one, other, three)
    decode(other, folder, "--shard", "2/3", "--glob", "0*", "--overwrite")
    assert "was made with another list of recordings" in complaint(one, other, three)
    lines = two.read_text().splitlines(keepends=True)
    two.write_text("".join(lines[:2]))
    assert "has more recordings" in complaint(one, two, three)
    whole = tmp_path / "whole.jsonl"
    decode(whole, folder / "00.flac")
    assert "is not a shard" in complaint(whole)
    assert not out.exists()


def test_a_full_disk_is_a_line_and_what_was_decoded_stays(
    decode: Decode, folder: Path, tmp_path: Path
) -> None:
    """A limit on the length of files stands for the disk."""
    out = tmp_path / "heard.jsonl"
    limited = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (32_000, 32_000)); "
    limited += "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
    limited += "from voz.cli import main; sys.exit(main())"
    command = [VOZ[0], "-c", limited, "decode", str(folder), "--no-network", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ, timeout=HANGS)
    assert done.returncode == 2
    assert "heard.jsonl.journal: cannot be written" in done.stderr
    assert not out.exists()
    assert "were known" in decode(out, folder, "--resume").err


def test_on_a_terminal_a_bar_tells_how_fast_it_goes(folder: Path, tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    out = tmp_path / "heard.jsonl"
    given = ["decode", folder, "--no-network", "--jobs", "2", "--out", out]
    command = [*VOZ, *map(str, given)]
    shown = b""
    environment = os.environ | {"TERM": "xterm"}  # in a dumb one nothing moves
    with subprocess.Popen(command, stderr=theirs, env=environment) as program:
        os.close(theirs)
        with suppress(OSError):  # the terminal is gone with the program
            while some := os.read(ours, 10_000):
                shown += some
    os.close(ours)
    assert program.returncode == 3
    plain = re.sub(rb"\x1b\[[0-9;?]*[A-Za-z]", b"", shown)
    assert re.search(rb"Decoding.* \d+/12 [\d.]+/s, \d+x [-\d]:", plain)
