"""What many tests need: the recordings, and a recogniser that is loaded once."""

from __future__ import annotations

import pytest
from _pytest.runner import runtestprotocol
from hypothesis import settings
from keeping_up import Metronome
from loudspeaker import loudspeaker
from pulseaudio import no_sound, own_pulse, pulse
from recordings import ROOT, Recording, read_manifest

from voz.language.files import LanguageFiles
from voz.recognition.language import Language, load_language
from voz.recognition.recognizer import Recognizer
from voz.settings import Recognition

__all__ = ["loudspeaker", "no_sound", "own_pulse", "pulse"]  # fixtures too

settings.register_profile("voz", deadline=None)  # a busy machine is no fault of what is tested
settings.load_profile("voz")


ATTEMPTS = 3
AGAIN = "tried again on a busy machine"


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Try a slow test that fails again, if the kernel says that the machine had no time for it.

    Slow ones wait for other programs, sounds and clocks. On a machine that has time the first
    failure counts, and on any the third; those that were tried again are told with the report.
    """
    if item.get_closest_marker("slow") is None:
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for attempt in range(1, ATTEMPTS + 1):
        item._initrequest()  # type: ignore[attr-defined]  # fixtures of its own are made anew
        with Metronome() as metronome:
            reports = runtestprotocol(item, log=False, nextitem=nextitem)
        failed = any(report.failed for report in reports)
        if not failed or metronome.keeps_up or attempt == ATTEMPTS:
            break
    for report in reports:
        report.user_properties += [(AGAIN, attempt)] * (attempt > 1)
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Tell which tests were tried again."""
    for category in ("passed", "failed"):
        for report in terminalreporter.getreports(category):
            if AGAIN in dict(report.user_properties) and report.when == "call":
                terminalreporter.write_line(f"{AGAIN}: {report.nodeid}")


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
