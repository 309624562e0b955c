"""Signals that end a program, in a program of its own."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap

import pytest
from calls import VOZ
from recordings import GO_BACK

from voz.process import signals

ENDING = [signal.SIGINT, signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP]


def program(body: str, *wrapper: str) -> subprocess.CompletedProcess[str]:
    """Run some lines in which `send` sends a signal to their own program."""
    before = """
        import os, queue, signal, sys, time, weakref
        from voz.process import signals

        def send(number):
            os.kill(os.getpid(), number)
            time.sleep(0.001)

        signals.install()
    """
    code = textwrap.dedent(before) + textwrap.dedent(body)
    command = [*wrapper, sys.executable, "-c", code]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=60, preexec_fn=as_a_terminal_has_them
    )


def as_a_terminal_has_them() -> None:
    for number in ENDING:
        signal.signal(number, signal.SIG_DFL)


@pytest.mark.parametrize("number", ENDING)
def test_before_a_run_drives_a_signal_ends_it_by_way_of_what_tidies_up(number: int) -> None:
    done = program(f"""
        try: send({number})
        finally: print(signals.first_signal())
    """)
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, f"{number}\n", "")


def test_who_says_nohup_means_it_and_a_background_job_is_ended_all_the_same() -> None:
    code = "send(signal.SIGHUP); print('on'); send(signal.SIGINT)"
    done = program(code, "sh", "-c", 'trap "" HUP INT; exec "$@"', "sh")
    assert (done.returncode, done.stdout) == (130, "on\n")


def test_signals_that_whoever_started_it_has_blocked_end_it_all_the_same() -> None:
    done = program("""
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
        os.kill(os.getpid(), signal.SIGTERM)
        print("blocked")
        signals.install()
        print("not reached")
    """)
    assert (done.returncode, done.stdout) == (143, "blocked\n")


def test_while_a_run_drives_a_signal_only_wakes_it() -> None:
    done = program("""
        inbox = queue.SimpleQueue()
        with signals.defer_signals(lambda: inbox.put("over")):
            send(signal.SIGTERM)
            print(inbox.get(), signals.first_signal())
            send(signal.SIGINT)
            print(inbox.get(), signals.first_signal())
    """)
    assert (done.returncode, done.stdout, done.stderr) == (0, "over 15\nover 15\n", "")


def test_a_second_ctrl_c_does_not_keep_the_robot_from_being_stopped() -> None:
    done = program("""
        with signals.defer_signals(lambda: None):
            send(signal.SIGINT)
        for _ in range(3):
            send(signal.SIGINT)
            send(signal.SIGTERM)
        print("stopped", signals.first_signal())
    """)
    assert (done.returncode, done.stdout, done.stderr) == (0, "stopped 2\n", "")


def test_after_a_run_that_ended_by_itself_a_signal_ends_the_program_again() -> None:
    done = program("""
        with signals.defer_signals(lambda: print("woken")):
            pass
        send(signal.SIGTERM)
        print("goes on")
    """)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "")


def test_a_signal_that_was_swallowed_before_is_found_when_the_run_is_to_begin() -> None:
    done = program("""
        try: send(signal.SIGINT)
        except BaseException: pass
        with signals.defer_signals(lambda: None):
            print("drives")
    """)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_a_signal_in_a_callback_that_nothing_can_be_raised_from_comes_again() -> None:
    done = program("""
        class Module: pass
        module = Module()
        kept = weakref.ref(module, lambda _: send(signal.SIGINT))
        del module  # as the locks of modules go after an import
        print("swallowed")
        time.sleep(30)
        print("goes on")
    """)
    assert (done.returncode, done.stdout, done.stderr) == (130, "swallowed\n", "")


def test_a_signal_that_comes_while_one_is_swallowed_waits_for_the_next_try() -> None:
    done = program("""
        received = signal.getsignal(signal.SIGINT)
        def where_it_is_swallowed(number):
            received(number, type("Frame", (), {"f_code": sys.unraisablehook.__code__}))
        where_it_is_swallowed(signal.SIGINT)
        print("noted", int(signals.first_signal()))
        try: received(signal.SIGTERM, sys._getframe())
        finally: print("ended")
    """)
    assert (done.returncode, done.stdout, done.stderr) == (130, "noted 2\nended\n", "")


def test_while_python_ends_a_signal_is_silent() -> None:
    done = program("""
        class Late:
            def __del__(self): os.kill(os.getpid(), signal.SIGHUP)
        late = Late()
        try: send(signal.SIGTERM)
        except SystemExit: pass
        signals.restore_default_handlers()
    """)
    assert (done.returncode, done.stderr) == (-signal.SIGHUP, "")


def test_other_exceptions_that_nobody_can_catch_are_told_as_ever() -> None:
    done = program("""
        class Broken:
            def __del__(self): raise ValueError("a bug")
        Broken()
    """)
    assert "ValueError: a bug" in done.stderr


SENDING = """
import os, sys
class Finder:
    def find_spec(self, name, *_):
        if name == {module!r}:
            sys.meta_path.remove(self)
            try: os.kill(os.getpid(), {number})
            except SystemExit: raise {raised}
sys.meta_path.insert(0, Finder())
"""


def signaled_at_import(
    module: str, number: int, raised: str = ""
) -> subprocess.CompletedProcess[str]:
    """Drive by a recording; a signal comes as a module is imported, which may raise another."""
    *python, last = VOZ
    before = SENDING.format(module=module, number=number, raised=raised)
    arguments = ["run", "--wav", str(GO_BACK), "--no-sound"]
    return subprocess.run(
        [*python, before + last, *arguments], capture_output=True, text=True, timeout=60
    )


@pytest.mark.parametrize(
    "module",
    [
        "voz.process.standard_streams",
        "inspect",
        "typer",
        "voz.cli.run_command",
        "msgspec",
        "numpy",
        "pocketsphinx",
    ],
)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_among_the_imports_is_a_quiet_end(module: str, number: int) -> None:
    done = signaled_at_import(module, number)
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, "", "")


@pytest.mark.parametrize("raised", ["ImportError('numpy')", "SystemError('odd')", "SystemExit(7)"])
def test_whatever_an_import_makes_of_a_signal_the_exit_code_says_it(raised: str) -> None:
    done = signaled_at_import("typer", signal.SIGTERM, raised)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "")


def test_nothing_is_imported_before_the_signals_are_taken_but_what_is_small() -> None:
    code = "import sys; before = set(sys.modules); import voz.cli; print(set(sys.modules) - before)"
    done = subprocess.run(
        [sys.executable, "-S", "-c", code], capture_output=True, text=True, check=True
    )
    assert not {"typer", "rich", "numpy", "msgspec", "inspect", "pathlib"} & set(eval(done.stdout))


def test_exit_codes_are_those_of_a_shell() -> None:
    assert signals.SIGNAL_EXIT_CODE + signal.SIGINT == 130


HANGS = """
import atexit, sys, threading, time
from voz.process.signals import force_exit, is_audio_thread_left
atexit.register(time.sleep, 60)  # as PortAudio waits for a server that hangs
assert not is_audio_thread_left()
threading.Thread(target=time.sleep, args=(60,), name="voz-hearing", daemon=True).start()
if is_audio_thread_left():
    force_exit(130)
try:
    sys.exit(5)
finally:
    print("all is saved", flush=True)
"""


def test_all_is_saved_and_the_exit_code_is_that_of_what_ended_it() -> None:
    done = subprocess.run([sys.executable, "-c", HANGS], capture_output=True, text=True, timeout=30)
    assert done.returncode == 130
    assert done.stdout == "all is saved\n"
