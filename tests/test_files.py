"""Files that are written whole or not at all."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO

import pytest
from full_disk import full_disk

from voz.errors import AudioError, ConfigError
from voz.files import (
    append_line,
    atomic_write,
    check_not_read,
    check_writable,
    read_bytes,
    read_json,
    read_text,
    shown_path,
)
from voz.printable import printable


@pytest.fixture
def nobody() -> Iterator[None]:
    """Run without the rights of root, to whom nothing is protected."""
    usual = os.geteuid()
    if usual == 0:
        os.seteuid(65534)
    yield
    os.seteuid(usual)


@pytest.fixture(params=["nameless", "named"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write as where files can get their names later, and as where they cannot."""
    if request.param == "named":
        monkeypatch.setattr("voz.files.OPEN_FILES_FOLDER", Path("/proc/no/such"))


either_way = pytest.mark.usefixtures("way")


def names(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()]


def half_written(file: IO[str], end: type[BaseException]) -> None:
    file.write("half")
    raise end


@either_way
def test_a_file_is_replaced_when_it_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old")
    with atomic_write(path) as file:
        file.write("new: ñ")
        file.flush()
        assert path.read_text() == "old"
    assert path.read_text(encoding="utf-8") == "new: ñ"
    assert names(tmp_path) == ["page.html"]


@either_way
@pytest.mark.parametrize("end", [ValueError, KeyboardInterrupt, SystemExit])
def test_whatever_ends_the_writing_the_old_file_stays(
    tmp_path: Path, end: type[BaseException]
) -> None:
    path = tmp_path / "page.html"
    path.write_text("old")
    with pytest.raises(end), atomic_write(path) as file:
        half_written(file, end)
    assert path.read_text() == "old"
    assert names(tmp_path) == ["page.html"]


@either_way
def test_a_file_that_was_never_complete_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), atomic_write(tmp_path / "data") as file:
        half_written(file, KeyboardInterrupt)
    assert not names(tmp_path)


HALF = """
import sys
from pathlib import Path

from voz.files import atomic_write

with atomic_write(Path(sys.argv[1])) as file:
    file.write("half")
    file.flush()
    print("written", flush=True)
    sys.stdin.read()
"""


def knows_files_without_names(folder: Path) -> bool:
    """Whether the file system does; some, as NFS or an old overlay, do not."""
    try:
        os.close(os.open(folder, os.O_TMPFILE | os.O_WRONLY))
    except OSError:
        return False
    return True


def test_of_a_program_that_is_killed_nothing_is_left(tmp_path: Path) -> None:
    path = tmp_path / "data"
    path.write_text("old")
    command = [sys.executable, "-c", HALF, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as program:
        assert program.stdout
        assert program.stdout.readline() == b"written\n"
        program.kill()
    assert path.read_text() == "old"
    assert len(names(tmp_path)) == (1 if knows_files_without_names(tmp_path) else 2)


@either_way
def test_a_full_disk_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "data"
    path.write_text("old")
    with full_disk(100), pytest.raises(OSError), atomic_write(path, "wb") as file:  # noqa: PT011
        file.write(bytes(10_000))
    assert path.read_text() == "old"
    assert names(tmp_path) == ["data"]


@either_way
def test_a_link_stays_and_what_it_points_to_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    real = tmp_path / "elsewhere" / "real.json"
    real.write_text("old")
    link = tmp_path / "link.json"
    link.symlink_to(real)
    with atomic_write(link) as file:
        file.write("new")
    assert link.is_symlink()
    assert real.read_text() == "new"


@either_way
def test_a_file_keeps_its_permissions_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    (tmp_path / "usual").touch()
    old, new = tmp_path / "old", tmp_path / "new"
    old.touch(0o640)
    for path in (old, new):
        with atomic_write(path) as file:
            file.write("new")
    assert old.stat().st_mode & 0o777 == 0o640
    assert new.stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_a_folder_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError), atomic_write(tmp_path):
        pytest.fail("it was opened")


def test_a_named_pipe_is_not_waited_for_and_that_of_a_shell_is_read_to_its_end(
    tmp_path: Path,
) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ConfigError, match=r"pipe: cannot be read \(it is a pipe\); give a file"):
        read_bytes(tmp_path / "pipe", ConfigError, "give a file")
    with pytest.raises(ConfigError, match=r"cannot be read \(Is a directory\)"):
        read_bytes(tmp_path, ConfigError, "give a file")
    ours, theirs = os.pipe()
    os.write(theirs, b"go forward")
    os.close(theirs)
    assert read_bytes(Path(f"/dev/fd/{ours}"), ConfigError, "") == b"go forward"
    os.close(ours)


def test_a_pipe_is_written_directly(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE) as reader:
        with atomic_write(pipe) as file:
            file.write("through")
        assert reader.communicate()[0] == b"through"
    assert pipe.is_fifo()


def test_a_protected_file_is_not_replaced(nobody: None) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder, "mine")
        path.write_text("old")
        path.chmod(0o444)
        with pytest.raises(PermissionError), atomic_write(path) as file:
            file.write("new")
        assert path.read_text() == "old"


def test_a_line_is_added_also_where_the_last_one_has_no_end(tmp_path: Path) -> None:
    path = tmp_path / "manifest.tsv"
    for line in ("first", "second"):
        append_line(path, line)
    path.write_text(path.read_text().rstrip("\n"))
    append_line(path, "third")
    assert path.read_text() == "first\nsecond\nthird\n"


def test_of_a_line_for_which_there_is_no_room_nothing_is_added(tmp_path: Path) -> None:
    path = tmp_path / "manifest.tsv"
    append_line(path, "first")
    with full_disk(10), pytest.raises(OSError):  # noqa: PT011
        append_line(path, "second, which is long")
    assert path.read_text() == "first\n"


def test_a_file_that_is_read_is_known_by_all_its_names(tmp_path: Path) -> None:
    read = tmp_path / "in.wav"
    read.write_text("sound")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("in.wav")
    (tmp_path / "hard").hardlink_to(read)
    (tmp_path / "new").symlink_to("not-there-yet")
    for name in ("in.wav", "folder/../in.wav", "link", "hard"):
        with pytest.raises(ConfigError, match="is read or written already"):
            check_not_read([tmp_path / name], [read])
        with pytest.raises(ConfigError, match="is read or written already"):
            check_not_read([tmp_path / name], [tmp_path])
    with pytest.raises(ConfigError, match="is read or written already"):
        check_not_read([tmp_path / "new", tmp_path / "not-there-yet"], [read])
    check_not_read(["/dev/null", "/dev/null", "-", tmp_path / "other"], [read, "/dev/null"])


def test_what_cannot_be_written_is_told_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("none/x")
    for name in ("none/x", "link", "."):
        with pytest.raises(ConfigError, match="cannot be written there; name a file in a folder"):
            check_writable(tmp_path / name)
    for path in (tmp_path / "new", Path("/dev/full")):
        check_writable(path)


def test_what_is_read_is_utf_8_with_any_line_ends(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_bytes(b"\xef\xbb\xbfo\xc3\xb1e\r\ntwo\rthree\n")
    assert read_text(path, ConfigError, "") == "oñe\ntwo\nthree\n"
    with pytest.raises(ConfigError, match=r"text: is larger than 9 bytes; make it smaller$"):
        read_text(path, ConfigError, "make it smaller", limit=9)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("/dev/zero", r"/dev/zero: is larger than 1,000 bytes; other"),
        ("/proc/self/mem", r"/proc/self/mem: cannot be read \(Input/output error\); other"),
        ("/", r"/: cannot be read \(Is a directory\); other"),
        ("none", r"none: cannot be read \(No such file or directory\); other"),
        ("x" * 5000, r"cannot be read \(File name too long\); other"),
        ("a\0b", r"'a\\x00b': cannot be the name of a file; other"),
        ("a\udcff\n", r"a\\xff\\n: cannot be read \(No such file or directory\); other"),
    ],
)
def test_what_cannot_be_read_is_one_line(path: str, said: str) -> None:
    with pytest.raises(AudioError, match=said) as caught:
        read_bytes(Path(path), AudioError, "other", limit=1000)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "data", [b"", b"[" * 100_000, b'["\xff"]', b"[1]", b'{"\\n": 1}', b"1e999"]
)
def test_json_of_another_kind_is_one_line(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "kept.json"
    path.write_bytes(data)
    with pytest.raises(
        ConfigError, match=r"kept\.json: cannot be used \(.*\); make it anew"
    ) as caught:
        read_json(path, list[str], ConfigError, "make it anew")
    assert str(caught.value).isprintable()


def test_whatever_a_message_quotes_it_is_one_line_for_any_terminal_and_json() -> None:
    message = str(ConfigError("a\nb\x1b[31m\0\udcff ñ \\n"))
    assert message == r"a\nb\x1b[31m\x00\udcff ñ \n"
    assert printable(message) == message
    assert shown_path(Path(os.fsdecode(b"\xff.wav"))) == r"\xff.wav"
