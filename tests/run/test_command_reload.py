"""Files of commands that are saved during a run, or are something else then."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from calls import in_process

from voz.api.recognizer import Recognizer
from voz.config import load_config
from voz.control.messages import Renewal
from voz.events import Notice
from voz.inbox import Inbox
from voz.language.language_files import LanguageFiles
from voz.run import command_reload
from voz.run.clocks import WallClock
from voz.run.command_reload import CommandReload, SettingsFile
from voz.run.programs import Programs

SENTENCES = "start speech\ngo forward\nstop\n"

HANGS = "import threading\n\nlet_go = threading.Event()\nlet_go.wait()\n\ndef wave():\n    pass\n"


class Watched:
    """A run of which only the reload is there."""

    def __init__(self, folder: Path, own: str = "") -> None:
        self.list, self.settings = folder / "list.txt", folder / "voz.toml"
        self.list.write_text(SENTENCES)
        self.settings.write_text(own)
        assert in_process("build-lm", str(self.list), "--out", str(folder / "lm")).code == 0
        self.recognizer = Recognizer(
            LanguageFiles(folder / "lm"), load_config(self.settings).recognition
        )
        self.inbox = Inbox(frozenset())
        settings = load_config(self.settings)
        programs = Programs(settings.table, lambda _: None, lambda _: None)
        self.reload = CommandReload(
            self.recognizer,
            settings,
            SettingsFile(self.settings, partial(load_config, self.settings)),
            programs.add,
            inbox=self.inbox,
            clock=WallClock(self.inbox),
        )

    def told(self) -> list[str]:
        """What a run is told after two looks at the files."""
        self.reload.look()
        self.reload.look()
        texts = []
        while (message := self.inbox.take(0.01)) is not None:
            assert isinstance(message, Notice | Renewal)
            texts.append(message.text if isinstance(message, Notice) else message.why)
        return texts


def test_robot_code_that_is_saved_is_said_to_be_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("my_robot.py", "arm.py", "other.py"):
        Path(name).write_text("def wave(): pass\n")
    own = '[commands]\n"go forward" = { call = ["arm:wave"] }\n'
    watched = Watched(tmp_path, f'robot = ["my_robot:Lamp", "console"]\n{own}')
    assert watched.told() == []
    for name in ("my_robot.py", "arm.py", "other.py"):
        Path(name).write_text("def wave(): return 1\n")
    assert sorted(watched.told()) == [
        "arm.py was saved: start voz again to take it",
        "my_robot.py was saved: start voz again to take it",
    ]
    Path("my_robot.py").unlink()
    assert watched.told() == []


@pytest.fixture
def watched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Watched:
    monkeypatch.chdir(tmp_path)
    return Watched(tmp_path)


@pytest.mark.parametrize("name", ["list", "settings"])
def test_a_file_that_is_something_else_now_is_told_as_that_and_taken_when_it_is_back(
    watched: Watched, name: str
) -> None:
    path: Path = getattr(watched, name)
    replaced: list[tuple[Callable[[Path], object], str]] = [
        (lambda path: None, "is gone"),
        (Path.mkdir, "is a folder now"),
        (os.mkfifo, "is no file any more"),
        (lambda path: path.symlink_to(path), "cannot be read (Too many levels of symbolic links)"),
        (lambda path: path.symlink_to("nowhere"), "is gone"),
        (lambda path: path.symlink_to("/dev/zero"), "is no file any more"),
    ]
    for replace, what in replaced:
        away = path.rename(path.with_name("away"))
        replace(path)
        assert watched.told() == [f"{path} {what}: the commands stay as they were"]
        assert watched.told() == []
        path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)
        away.rename(path)
        assert watched.told() == [f"{path} was saved", "the commands were renewed: 3 sentences"]
        assert watched.told() == []
    watched.list.write_text(SENTENCES + "wave\n")
    assert watched.told()[1:] == ['the commands were renewed: new "wave"']


def test_an_unreadable_list_is_told_as_that(monkeypatch: pytest.MonkeyPatch) -> None:
    with TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        monkeypatch.chdir(folder)
        watched = Watched(Path(folder))
        watched.list.chmod(0)
        usual = os.geteuid()
        if usual == 0:  # to whom nothing is protected
            os.seteuid(65534)
        told = watched.told()
        os.seteuid(usual)
    why = "cannot be read (Permission denied): the commands stay as they were"
    assert told == [f"{watched.list} {why}"]


def test_what_a_list_imports_is_no_pipe_either(watched: Watched) -> None:
    os.mkfifo(watched.list.with_name("pipe.txt"))
    watched.list.write_text(SENTENCES + "import pipe.txt\n")
    (refused,) = watched.told()
    assert refused.startswith("the new commands are not taken: ")
    assert "it is a pipe" in refused
    watched.list.write_text(SENTENCES + "wave\n")
    assert watched.told()[1:] == ['the commands were renewed: new "wave"']


def test_a_file_that_a_list_imports_since_it_was_saved_is_watched_once(watched: Watched) -> None:
    other = watched.list.with_name("other.txt")
    other.write_text("wave\n")
    watched.list.write_text(SENTENCES + "import other.txt\n")
    assert watched.told()[1:] == ['the commands were renewed: new "wave"']
    assert watched.told() == []
    other.unlink()
    assert watched.told() == [f"{other} is gone: the commands stay as they were"]
    other.write_text("wave\ndance\n")
    assert watched.told()[1:] == ['the commands were renewed: new "dance"']


@pytest.fixture
def no_patience(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(command_reload, "READ_TIMEOUT", 0.05)
    before = set(threading.enumerate())
    yield
    sys.modules.pop("hangs").let_go.set()
    for thread in set(threading.enumerate()) - before:
        thread.join()


@pytest.mark.usefixtures("no_patience")
def test_an_import_that_hangs_is_told_and_later_saves_are_taken(
    watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    watched.list.with_name("hangs.py").write_text(HANGS)
    watched.settings.write_text('[commands]\n"wave" = { call = ["hangs:wave"] }\n')
    late = "importing hangs:wave has not ended after 0.05 s; mend it, and start voz again"
    assert watched.told() == [f"the new commands are not taken: {late}"]
    assert watched.told() == []
    monkeypatch.setattr(command_reload, "READ_TIMEOUT", 60.0)
    watched.list.write_text(SENTENCES + "wave\n")
    assert watched.told()[1:] == ['the commands were renewed: new "wave"']
    watched.settings.write_text('[commands]\n"wave" = { say = "hello" }\n')
    assert watched.told()[1:] == ['the commands were renewed: changed "wave"']


def test_what_sounds_alike_is_told_of_new_pairs_alone(watched: Watched) -> None:
    text = "start speech\nstop\nstop speech\n"
    for new, alike in (
        ("open gripper\n", []),
        ("stop peach\n", ['"stop speech" and "stop peach"', '"start speech" and "stop peach"']),
        ("fold arm\n", []),
        ("go write\ngo right\n", ['"go write" and "go right"']),
    ):
        text += new
        watched.list.write_text(text)
        told = [
            line.partition(" sound alike")[0] for line in watched.told() if "sound alike" in line
        ]
        assert told == alike
