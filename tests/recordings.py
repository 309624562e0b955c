"""The recorded fixtures, for all tests that listen."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from voz.apps.recordings.manifest import MANIFEST_NAME, parse_records
from voz.audio import Samples
from voz.audio.sound_files import read_samples
from voz.speech.synthesis import cached_speech

ROOT = Path(__file__).parent.parent
FIXTURES = ROOT / "audio_fixtures"
GO_BACK = FIXTURES / "commands" / "festival_slt__go_back.flac"


class Recording(NamedTuple):
    path: Path
    text: str
    voice: str
    kind: str

    @property
    def commands(self) -> list[str]:
        return self.text.split(" | ")

    def samples(self) -> Samples:
        return read_samples(self.path)


def read_manifest() -> list[Recording]:
    rows = parse_records((FIXTURES / MANIFEST_NAME).read_text(encoding="utf-8"))
    return [Recording(FIXTURES / r["file"], r["text"], r["voice"], r["kind"]) for r in rows]


def spoken(text: str, voice: str = "kal_diphone") -> Samples:
    """A text by a voice of festival."""
    return read_samples(cached_speech(text, voice))
