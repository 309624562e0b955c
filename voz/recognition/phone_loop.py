"""Phones as pocketsphinx's filler words, whose underscore no command has."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from voz.language.acoustic_model import SILENCE_PHONE
from voz.recognition.search_graph import SILENCE, phone_word


@contextmanager
def filler_dictionary(phones: Iterable[str]) -> Iterator[Path]:
    """Write a dictionary of silences and phones, and delete it afterward."""
    words = [f"{word} {SILENCE_PHONE}" for word in ("<s>", "</s>", SILENCE)]
    words += [f"{phone_word(phone)} {phone}" for phone in phones]
    with tempfile.NamedTemporaryFile(
        "w", prefix="voz-", suffix=".filler_dictionary", encoding="utf-8"
    ) as file:
        file.write("".join(f"{line}\n" for line in words))
        file.flush()
        yield Path(file.name)
