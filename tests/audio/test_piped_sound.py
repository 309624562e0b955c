"""Sound from a pipe."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from voz.audio.piped_sound import piped_blocks
from voz.errors import AudioError


def test_more_channels_than_sound_has_are_refused_before_a_block_is_made(
    tmp_path: Path,
) -> None:
    channels, rate, width = 1000, 768_000, 2
    layout = struct.pack("<HHIIHH", 1, channels, rate, 0, channels * width, 8 * width)
    chunks = b"WAVEfmt " + struct.pack("<I", len(layout)) + layout + b"data\xff\xff\xff\x7f"
    (tmp_path / "pipe").write_bytes(b"RIFF\xff\xff\xff\x7f" + chunks + bytes(1000))
    with (tmp_path / "pipe").open("rb") as stream, pytest.raises(AudioError) as raised:
        list(piped_blocks(stream, None))
    assert str(raised.value) == "-: has 1000 channels; pipe one"
