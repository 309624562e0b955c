"""The spoken language: its acoustic model, and the properties of the model's phones."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import msgspec

from voz.language.acoustics.phone_distances import PhoneDistances, read_distances

ENGLISH_NAMES = frozenset({"english", "en"})

ENGLISH_MODEL = "en-us/en-us"
"""Path within the pocketsphinx package."""


class LanguageInfo(msgspec.Struct, frozen=True, dict=True):
    """A spoken language, as the language files keep it.

    Attributes:
        name: what the user calls it.
        acoustic_model: the folder of the model, relative to that of the language files or absolute;
            None is pocketsphinx's English model.
        model: the SHA-256 of the model; empty for pocketsphinx's own.
        frames: how many frames of 10 ms each phone lasts.
        apart: what a frame of one phone loses, in nats, if it is taken for another.
    """

    name: str
    acoustic_model: str | None
    model: str
    frames: dict[str, float]
    apart: dict[str, dict[str, float]]

    @property
    def is_english(self) -> bool:
        """Whether the accents and the phoneme network, which are English, can be used."""
        return self.name.lower() in ENGLISH_NAMES

    @property
    def code(self) -> str:
        """The language for other programs: `en`, else the name that the user gave, such as `es`."""
        return "en" if self.is_english else self.name

    @property
    def uses_default_model(self) -> bool:
        """Whether the model is pocketsphinx's own."""
        return self.acoustic_model is None

    @cached_property
    def phones(self) -> frozenset[str]:
        """The names of the phones."""
        return frozenset(self.frames)

    @cached_property
    def distances(self) -> PhoneDistances:
        """How far apart the phones are."""
        return PhoneDistances(self.frames, self.apart)

    def folder(self, language: Path) -> Path:
        """Return the folder of the acoustic model; `language` is that of the language files."""
        if self.acoustic_model is None:
            import pocketsphinx  # takes 20 ms, which typed commands save

            return Path(pocketsphinx.get_model_path(ENGLISH_MODEL))
        return language / self.acoustic_model


def english() -> LanguageInfo:
    """Return English with pocketsphinx's model and the measured distances."""
    known = read_distances()
    apart = {phone: dict(others) for phone, others in known.apart.items()}
    return LanguageInfo("English", None, "", dict(known.frames), apart)
