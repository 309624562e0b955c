"""A new list that cannot be taken, whatever it fails of."""

from __future__ import annotations

import pytest

from voz.config import default_commands
from voz.errors import LanguageError
from voz.recognition.recognizer import Recognizer
from voz.run.command_reload import _reload


@pytest.mark.parametrize(
    ("error", "why"), [(LanguageError("no list"), "no list"), (MemoryError(), "MemoryError")]
)
def test_what_cannot_be_loaded_is_told_and_the_old_list_stays(
    error: Exception, why: str, recognizer: Recognizer, monkeypatch: pytest.MonkeyPatch
) -> None:
    def reload(*_: object) -> None:
        raise error

    monkeypatch.setattr(recognizer, "reload", reload)
    before, told = recognizer.commands, list[tuple[str, bool]]()
    _reload(recognizer, default_commands(), lambda line, good: told.append((line, good)))
    ((line, good),) = told
    assert line.startswith(f"the new commands are not taken: {why}")
    assert not good
    assert recognizer.commands is before
