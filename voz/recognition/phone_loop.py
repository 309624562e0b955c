"""The phones of an acoustic model as words of their own. An edge: pocketsphinx reads a file.

No command has an underscore, so the words cannot be those of a list.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from voz.language.acoustics.acoustic_model import SILENCE_PHONE
from voz.recognition.search_graph import SILENCE, phone_word


@contextmanager
def fillers(phones: Iterable[str]) -> Iterator[Path]:
    """Write a dictionary of fillers: silences, and each phone.

    Args:
        phones: those of the acoustic model, in any order.

    Yields:
        The file; it may go as soon as pocketsphinx has read it.
    """
    words = [f"{word} {SILENCE_PHONE}" for word in ("<s>", "</s>", SILENCE)]
    words += [f"{phone_word(phone)} {phone}" for phone in phones]
    with tempfile.NamedTemporaryFile(
        "w", prefix="voz-", suffix=".fillers", encoding="utf-8"
    ) as file:
        file.write("".join(f"{line}\n" for line in words))
        file.flush()
        yield Path(file.name)
