"""What many tests need: the recordings, and a recognizer that is loaded once."""

from __future__ import annotations

import ast
import fcntl
import functools
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, nullcontext
from io import BytesIO, TextIOWrapper
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as programs of voz, before numpy is loaded

import pytest
from calls import Result
from hypothesis import settings
from loudspeaker import loudspeaker
from programs import PATIENCE
from pulseaudio import no_sound, own_pulse, pulse
from recordings import ROOT, Recording, read_manifest
from xdist.remote import Producer
from xdist.scheduler import LoadFileScheduling

from voz.api.recognizer import Recognizer
from voz.apps.batch.executors import InlineExecutor
from voz.apps.batch.worker import WorkerSetup
from voz.cli import main
from voz.language.language_files import LanguageFiles
from voz.process.signals import AUDIO_THREADS
from voz.recognition.language import Language, load_language
from voz.settings import Recognition

__all__ = ["loudspeaker", "no_sound", "own_pulse", "pulse"]  # fixtures too

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as of what a shell starts by `&`
    signal.signal(signal.SIGINT, signal.default_int_handler)  # for programs that tests start too

settings.register_profile("voz", deadline=None)  # a busy machine is no fault of what is tested
settings.load_profile("voz")


REALTIME, REALTIME_MARK, NICE = "realtime", "mark.realtime", 10


class OneProcessInRealTime(LoadFileScheduling):
    """Distributes tests by files; those that need real seconds run one by one in one process."""

    def _split_scope(self, nodeid: str) -> str:
        path, _, name = nodeid.partition("::")
        return REALTIME if name.partition("[")[0] in realtime_tests(path) else path


@functools.cache
def realtime_tests(path: str) -> Collection[str]:
    """The tests of a file that have the mark; what distributes the tests does not import them."""
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    tests = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    whole = [node.value for node in tree.body if isinstance(node, ast.Assign) and is_mark(node)]
    marked = any(REALTIME_MARK in ast.unparse(value) for value in whole)
    return {
        test.name
        for test in tests
        if marked or any(REALTIME_MARK in ast.unparse(each) for each in test.decorator_list)
    }


def is_mark(node: ast.Assign) -> bool:
    return ast.unparse(node.targets[0]) == "pytestmark"


@pytest.hookimpl(optionalhook=True)  # benchmarks/mutants.py leaves xdist out
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> OneProcessInRealTime:
    return OneProcessInRealTime(config, log)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let the tests that compute give way to those that need real seconds."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return
    path, _, name = item.nodeid.partition("::")
    in_real_time = item.get_closest_marker(REALTIME) is not None
    assert in_real_time == (name.partition("[")[0] in realtime_tests(path)), (
        "write the mark plainly"
    )
    if not in_real_time and os.nice(0) < NICE:
        os.nice(NICE)


@pytest.fixture(autouse=True)
def no_audio_thread_left() -> Iterator[None]:
    """A test whose audio thread goes on fails: voz silences its libraries as long as one does."""
    before = set(threading.enumerate())
    yield
    for thread in set(threading.enumerate()) - before:
        if thread.name in AUDIO_THREADS:
            thread.join(PATIENCE)
            assert not thread.is_alive(), thread


@pytest.fixture(autouse=True)
def machine(request: pytest.FixtureRequest) -> Iterator[None]:
    """Hold back the tests of other processes while one runs that needs the whole machine."""
    alone = request.node.get_closest_marker("alone") is not None
    locks = [
        Path(tempfile.gettempdir()) / f"voz-tests-{os.getuid()}.{name}"
        for name in ("gate", "machine")
    ]
    with locks[0].open("w") as gate, locks[1].open("w") as machine:
        fcntl.flock(gate, fcntl.LOCK_EX)  # so that no others begin while one waits for its turn
        fcntl.flock(machine, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        fcntl.flock(gate, fcntl.LOCK_UN)
        yield
        fcntl.flock(machine, fcntl.LOCK_UN)  # closing is not enough: a fork may have it, too


@pytest.fixture
def begun() -> Callable[[], list[threading.Thread]]:
    """Which threads began in the test and go on; one of another test's may hang beside them."""
    before = set(threading.enumerate())
    return lambda: list(set(threading.enumerate()) - before)


@pytest.fixture(scope="session")
def recordings() -> list[Recording]:
    return read_manifest()


@pytest.fixture(scope="session")
def session(recordings: list[Recording]) -> Recording:
    """Eleven commands in 22 s, with pauses, in a quiet room."""
    return next(r for r in recordings if r.path.name == "session.wav")


@pytest.fixture(scope="session")
def language() -> LanguageFiles:
    return LanguageFiles(ROOT / "lm")


@pytest.fixture(scope="session")
def loaded(language: LanguageFiles) -> Language:
    return load_language(language)


@pytest.fixture(scope="session")
def recognizer(language: LanguageFiles) -> Recognizer:
    return Recognizer(language, Recognition())


@pytest.fixture
def voz(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., Result]:
    """Call the command in this process: ten times faster than in one of its own."""
    monkeypatch.setattr(signal, "signal", lambda *_: None)  # pytest's own stay
    monkeypatch.chdir(ROOT)

    def call(*arguments: object, cwd: Path | str = ".", typed: str | None = None) -> Result:
        capfd.readouterr()
        with monkeypatch.context() as patched:
            patched.chdir(cwd)
            if typed is not None:
                patched.setattr("sys.stdin", TextIOWrapper(BytesIO(typed.encode())))
            code = main([str(argument) for argument in arguments])
        return Result(code, *capfd.readouterr())

    return call


@pytest.fixture
def inline(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let recordings be decoded in this process where voz begins another for them."""

    def here(setup: WorkerSetup, _: int) -> AbstractContextManager[InlineExecutor]:
        return nullcontext(InlineExecutor(setup))

    monkeypatch.setattr("voz.apps.batch.batch_decoder.process_executor", here)
