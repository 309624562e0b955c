"""WAV files whose header has no length, samples of all widths, and headers that are damaged."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import read_blocks, read_samples, to_samples
from voz.audio.wav import has_unsigned_bytes, pcm_samples, read_wav_header
from voz.errors import AudioError

NOISE = np.random.default_rng(0).normal(0, 0.1, 12_346)  # an odd number of bytes would be padded


def without_length(path: Path, riff: bytes = bytes(4), data: bytes = bytes(4)) -> Path:
    """What a recorder leaves that was killed before it wrote the lengths."""
    content = bytearray(path.read_bytes())
    header = read_wav_header(io.BytesIO(content).read)
    assert header
    content[4:8], content[header.samples_at - 4 : header.samples_at] = riff, data
    if (at := content.find(b"ds64")) > 0:
        content[at + 8 : at + 32] = bytes(24)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "PCM_U8", "FLOAT", "ULAW"])
@pytest.mark.parametrize("format_", ["WAV", "WAVEX", "RF64"])
@pytest.mark.parametrize("data", [bytes(4), b"\xff" * 4])
def test_a_recorder_that_was_killed_leaves_what_is_read(
    subtype: str, format_: str, data: bytes, tmp_path: Path
) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, NOISE, SAMPLE_RATE, subtype, format=format_)
    if path.read_bytes()[:4] == b"RF64":
        data = b"\xff" * 4  # its lengths stand in another chunk
    whole = read_samples(path)
    found = read_samples(without_length(path, data, data))
    assert np.array_equal(found, whole)


def test_half_a_frame_at_the_end_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, np.stack([NOISE, NOISE], axis=1), SAMPLE_RATE)
    without_length(path).write_bytes(path.read_bytes() + b"abc")
    assert sum(map(len, read_blocks(path))) == len(NOISE)


def test_what_stands_behind_no_samples_is_no_sound(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, np.zeros(0), SAMPLE_RATE)
    note = b"LIST" + struct.pack("<I", 10) + b"INFOhello!"
    path.write_bytes(path.read_bytes() + note)
    with pytest.raises(AudioError, match="holds no sound"):
        list(read_blocks(path))


@pytest.mark.parametrize(("subtype", "width"), [("PCM_U8", 1), ("PCM_16", 2), ("PCM_24", 3)])
def test_samples_are_those_that_libsndfile_reads(subtype: str, width: int, tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, NOISE, SAMPLE_RATE, subtype)
    with path.open("rb") as file:
        header = read_wav_header(file.read)
        assert header
        data = file.read(header.data_bytes)
    assert (header.width, header.channels, header.rate) == (width, 1, SAMPLE_RATE)
    found = to_samples(pcm_samples(data, width), SAMPLE_RATE)
    assert np.array_equal(found, read_samples(path))


def test_bytes_are_unsigned_if_silence_is_in_the_middle() -> None:
    samples = np.rint(40 * NOISE)
    unsigned, signed = (samples + 128).astype(np.uint8), samples.astype(np.int8)
    assert has_unsigned_bytes(unsigned.tobytes())
    assert not has_unsigned_bytes(signed.tobytes())
    same = pcm_samples(signed.tobytes(), 1, unsigned=False)
    assert np.array_equal(same, pcm_samples(unsigned.tobytes(), 1))


@given(st.binary(max_size=80), st.integers(0, 60))
def test_no_header_is_an_exception(damage: bytes, at: int) -> None:
    file = io.BytesIO()
    soundfile.write(file, NOISE[:100], SAMPLE_RATE, format="WAVEX")
    content = bytearray(file.getvalue())
    content[at : at + len(damage)] = damage
    header = read_wav_header(io.BytesIO(content).read)
    assert header is None or header.width >= 0
