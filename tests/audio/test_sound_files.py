"""Recordings of every kind become 16 kHz mono samples, and bad ones one clear line."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st
from recordings import Recording

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import (
    ArrayConverter,
    Resampler,
    read_blocks,
    read_samples,
    read_sound,
    to_int16,
    to_samples,
)
from voz.errors import AudioError


def tone(rate: int, seconds: float = 1.0) -> np.ndarray:
    return 0.5 * np.sin(2 * np.pi * 440 * np.arange(int(rate * seconds)) / rate)


def read(path: Path) -> Samples:
    return read_samples(path)


def error_of(path: Path) -> str:
    with pytest.raises(AudioError) as caught:
        list(read_blocks(path))
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message


def truncated(path: Path, size: int) -> Path:
    path.write_bytes(path.read_bytes()[:size])
    return path


def test_a_16_khz_recording_is_read_bit_for_bit(tmp_path: Path) -> None:
    samples = np.random.default_rng(0).integers(-32768, 32767, 50_000).astype(np.int16)
    soundfile.write(tmp_path / "a.wav", samples, SAMPLE_RATE)
    assert np.array_equal(read(tmp_path / "a.wav"), samples)


@pytest.mark.parametrize("rate", [8000, 11025, 22050, 44100, 48000, 96000])
@pytest.mark.parametrize("channels", [1, 2, 6])
def test_any_rate_and_channels_become_16_khz_mono(rate: int, channels: int, tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, np.stack([tone(rate)] * channels, axis=1), rate)
    samples = read(path)
    assert samples.dtype == np.int16
    assert abs(len(samples) - SAMPLE_RATE) <= 2
    expected = 32768 * tone(SAMPLE_RATE)
    middle = slice(1000, -1000)  # the resampler rings at the ends
    assert np.abs(samples[middle] - expected[: len(samples)][middle]).max() < 200


@pytest.mark.parametrize(
    ("name", "subtype"), [("a.flac", "PCM_24"), ("a.ogg", "VORBIS"), ("a.wav", "ULAW")]
)
def test_other_formats_are_read(name: str, subtype: str, tmp_path: Path) -> None:
    soundfile.write(tmp_path / name, tone(SAMPLE_RATE), SAMPLE_RATE, subtype)
    samples = read(tmp_path / name)
    assert abs(len(samples) - SAMPLE_RATE) < 200
    assert 15_000 < samples.max() < 18_000


def test_samples_beyond_full_scale_are_clipped_and_do_not_wrap_round(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", 4 * tone(SAMPLE_RATE), SAMPLE_RATE, "FLOAT")
    samples = read(tmp_path / "a.wav")
    assert (samples.min(), samples.max()) == (-32768, 32767)
    assert np.abs(np.diff(samples.astype(int))).max() < 30_000


def test_a_long_recording_comes_in_short_blocks(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", np.zeros((44100 * 60, 2), np.int16), 44100)
    assert max(len(block) for block in read_blocks(tmp_path / "a.wav")) <= 2 * SAMPLE_RATE


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    assert "no such file" in error_of(tmp_path / "a.wav")
    assert "is a folder" in error_of(tmp_path)


def test_a_pipe_is_refused_and_does_not_hang(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert "no regular file" in error_of(tmp_path / "pipe")


@pytest.mark.parametrize("content", [b"", b"RIFF", b"this is text\n" * 100])
def test_what_is_no_recording(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.wav").write_bytes(content)
    assert "no recording that can be read" in error_of(tmp_path / "a.wav")


def test_a_recording_without_a_sample(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", np.zeros(0, np.int16), SAMPLE_RATE)
    assert "holds no sound" in error_of(tmp_path / "a.wav")


def test_a_header_alone_holds_no_sound(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", tone(SAMPLE_RATE), SAMPLE_RATE)
    assert "holds no sound" in error_of(truncated(tmp_path / "a.wav", 44))


def test_a_truncated_wav_gives_what_is_there_and_then_the_error(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, tone(SAMPLE_RATE, 3), SAMPLE_RATE)
    truncated(path, 44 + 2 * SAMPLE_RATE)
    blocks = []
    with pytest.raises(AudioError, match=r"cut short, the last 2\.0 s are missing"):
        blocks.extend(read_blocks(path))
    assert "cut short" in error_of(path)


def test_a_truncated_flac(tmp_path: Path) -> None:
    path = tmp_path / "a.flac"
    soundfile.write(path, np.random.default_rng(0).normal(0, 0.1, 48_000), SAMPLE_RATE)
    error_of(truncated(path, path.stat().st_size // 2))


@pytest.mark.parametrize("channels", [1, 2])
def test_floats_that_nobody_scaled_are_cut_off_without_a_warning(
    channels: int, tmp_path: Path
) -> None:
    samples = np.full((SAMPLE_RATE, channels), 3e38, np.float32)
    soundfile.write(tmp_path / "a.wav", samples, SAMPLE_RATE, "FLOAT")
    assert np.median(read(tmp_path / "a.wav")) == 32767


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_samples_that_are_no_numbers(value: float, tmp_path: Path) -> None:
    samples = tone(SAMPLE_RATE)
    samples[100] = value
    soundfile.write(tmp_path / "a.wav", samples, SAMPLE_RATE, "FLOAT")
    assert "no numbers" in error_of(tmp_path / "a.wav")


@pytest.mark.parametrize("rate", [1, 3999, 2_000_000_000])
def test_a_rate_that_cannot_be(rate: int, tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", np.zeros(100, np.int16), rate)
    assert f"{rate} Hz is not usable" in error_of(tmp_path / "a.wav")


# Sounds to be played


def sound_error(path: Path) -> str:
    with pytest.raises(AudioError) as caught:
        read_sound(path, 48_000)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message


def noise(seconds: float) -> np.ndarray:
    return np.random.default_rng(0).normal(0, 0.1, int(48_000 * seconds)).astype(np.float32)


def test_a_sound_of_the_wanted_rate_is_read_bit_for_bit(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", noise(2.5), 48_000, "FLOAT")
    assert np.array_equal(read_sound(tmp_path / "a.wav", 48_000), noise(2.5))


@pytest.mark.parametrize("name", ["a.wav", "a.flac", "a.ogg"])
def test_a_sound_of_another_rate_and_format_is_converted(name: str, tmp_path: Path) -> None:
    soundfile.write(tmp_path / name, np.stack([tone(22_050)] * 2, axis=1), 22_050)
    samples = read_sound(tmp_path / name, 48_000)
    assert samples.dtype == np.float32
    assert abs(len(samples) - 48_000) < 3
    assert np.abs(samples[2000:-2000] - tone(48_000)[: len(samples)][2000:-2000]).max() < 0.03


def test_sounds_that_cannot_be_played(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "long.wav", np.zeros(601 * 4000, np.int16), 4000)
    assert "longer than 10 minutes" in sound_error(tmp_path / "long.wav")
    assert "no such file" in sound_error(tmp_path / "none.wav")


@pytest.mark.parametrize("subtype", ["VORBIS", "OPUS"])
@pytest.mark.parametrize("left", [0.02, 0.5, 0.9, 0.9999])
def test_an_ogg_that_is_cut_short(subtype: str, left: float, tmp_path: Path) -> None:
    path = tmp_path / "a.ogg"
    soundfile.write(path, noise(3), 48_000, format="OGG", subtype=subtype)
    assert len(read_sound(path, 48_000)) == len(noise(3))
    size = path.stat().st_size
    truncated(path, min(int(left * size), size - 1))
    sound_error(path)


def test_an_ogg_with_a_hole(tmp_path: Path) -> None:
    path = tmp_path / "a.ogg"
    soundfile.write(path, noise(3), 48_000)
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 3000] = bytes(3000)
    path.write_bytes(data)
    assert "cut short" in sound_error(path)
    assert "cut short" in error_of(path)


def test_what_is_right_already_stays_as_it_is(session: Recording) -> None:
    samples = session.samples()
    assert np.array_equal(to_samples(samples, SAMPLE_RATE), samples)
    assert np.array_equal(to_samples(samples / 32768, SAMPLE_RATE), samples)


@given(st.lists(st.integers(0, 700), max_size=12))
def test_the_size_of_the_blocks_does_not_matter(sizes: list[int]) -> None:
    sound = np.random.default_rng(0).integers(-9000, 9000, (sum(sizes), 2)).astype(np.int16)
    converter, at, found = ArrayConverter(24_000), 0, []
    for size in sizes:
        found.append(converter.feed(sound[at : at + size]))
        at += size
    whole = np.concatenate([*found, converter.finish()])
    assert np.abs(whole.astype(int) - to_samples(sound, 24_000)).max(initial=0) <= 1


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.zeros((2, 16000), np.int16), r"shape \(2, 16000\).*turn it round"),
        (np.zeros((2, 3, 4), np.int16), "samples x channels"),
        (np.zeros(9, np.int32), "samples are int32; give int16, or floats"),
        (np.array(["a"]), "give int16"),
        (np.array([0.0, np.nan]), "no numbers"),
        (np.array([0.0, 1200.0]), "one is 1200; divide by 32768"),
        (np.array(0.5), "samples x channels"),
    ],
)
def test_what_is_no_sound_is_one_clear_error(array: np.ndarray, said: str) -> None:
    with pytest.raises(AudioError, match=said):
        to_samples(array, SAMPLE_RATE)


@pytest.mark.parametrize("rate", [0, 300, -16000, 1e9, float("nan"), "16000", [16000]])
def test_a_rate_without_speech_is_refused(rate: Any) -> None:
    with pytest.raises(AudioError, match="is not usable; give one from"):
        to_samples(np.zeros(9, np.int16), rate)


@pytest.mark.parametrize("rate", [SAMPLE_RATE, 44_100])
def test_a_stream_that_is_finished_says_so(rate: int) -> None:
    converter = ArrayConverter(rate)
    converter.feed(np.zeros(rate, np.int16))
    converter.finish()
    with pytest.raises(AudioError, match="is finished; begin another"):
        converter.feed(np.zeros(rate, np.int16))
    assert len(converter.finish()) == 0


@pytest.mark.parametrize("rate", [8000, 44_100, 48_000])
def test_nothing_is_lost_between_blocks(rate: int) -> None:
    tone = np.sin(2 * np.pi * 300 * np.arange(rate) / rate).astype(np.float32) / 2
    resampler = Resampler(rate)
    parts = [resampler.feed(tone[at : at + 777]) for at in range(0, rate, 777)]
    found = np.concatenate([*parts, resampler.finish()])
    assert abs(len(found) - SAMPLE_RATE) <= 1
    expected = 16384 * np.sin(2 * np.pi * 300 * np.arange(len(found)) / SAMPLE_RATE)
    assert np.abs(found - expected)[500:-500].max() < 50


# Recordings that are read otherwise than they stand there


def warned(path: Path) -> tuple[Samples, list[str]]:
    warnings: list[str] = []
    return read_samples(path, warnings.append), warnings


@pytest.mark.parametrize("rate", [SAMPLE_RATE, 44_100])
def test_channels_out_of_phase_are_heard_with_a_word(rate: int, tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, np.stack([tone(rate, 3), -tone(rate, 3)], axis=1), rate)
    samples, (warning,) = warned(path)
    assert samples[SAMPLE_RATE:].max() == pytest.approx(16384, rel=0.01)
    assert warning.startswith(f"{path}: its channels are out of phase")


def test_arrays_out_of_phase_are_heard_with_a_word() -> None:
    said: list[str] = []
    converter = ArrayConverter(SAMPLE_RATE, said.append)
    stereo = np.stack([tone(SAMPLE_RATE), -tone(SAMPLE_RATE)], axis=1)
    found = [converter.feed(block) for block in np.array_split(stereo, 50)]
    assert np.abs(np.concatenate(found)[2000:]).max() > 16_000
    assert len(said) == 1
    assert "out of phase" in said[0]


@pytest.mark.parametrize(
    ("factor", "how"), [(2.0**15, "32768"), (2.0**23, "8.38861e+06"), (20, "")]
)
def test_floats_that_nobody_scaled_are_scaled_with_a_word(
    factor: float, how: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.wav"
    quiet_at_first = np.concatenate([tone(SAMPLE_RATE, 2) / 1000, 2 * tone(SAMPLE_RATE)])
    soundfile.write(path, factor * quiet_at_first, SAMPLE_RATE, "FLOAT")
    samples, (warning,) = warned(path)
    assert f"has samples up to {factor:.6g}, where 1 is full scale; voz divides by {how}" in warning
    assert samples.max() == pytest.approx(32767, rel=0.01)
    assert 10 < samples[: 2 * SAMPLE_RATE].max() < 20


def test_an_mp3_in_a_wav_is_whole(tmp_path: Path) -> None:
    size, rate = 108, SAMPLE_RATE  # of a frame of 24 kbit/s, in which there are 576 samples
    frames = (b"\xff\xf3\x38\xc4" + bytes(size - 4)) * 84
    layout = struct.pack("<HHIIHHHHIHHH", 0x55, 1, rate, 3000, 1, 0, 12, 1, 2, size, 1, 1393)
    chunks = b"WAVEfmt " + struct.pack("<I", len(layout)) + layout
    chunks += b"data" + struct.pack("<I", len(frames)) + frames
    (tmp_path / "a.wav").write_bytes(b"RIFF" + struct.pack("<I", len(chunks)) + chunks)
    assert len(read(tmp_path / "a.wav")) == pytest.approx(84 * 576, abs=1200)


def test_a_flac_that_came_from_a_pipe_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.flac"
    soundfile.write(path, tone(SAMPLE_RATE, 2.5), SAMPLE_RATE)
    whole, content = read(path), bytearray(path.read_bytes())
    content[21] &= 0xF0  # the number of samples has 36 bits
    content[22:26] = bytes(4)
    path.write_bytes(content)
    assert np.array_equal(read(path), whole)
    assert len(read_sound(path, SAMPLE_RATE)) == len(whole)


def test_a_format_that_is_not_read_is_to_be_converted(tmp_path: Path) -> None:
    path = tmp_path / "my take.m4a"
    path.write_bytes(b"\0\0\0\x18ftypM4A " + bytes(100))
    assert error_of(path).endswith(f"ffmpeg -i '{path}' '{tmp_path}/my take.wav'")


def test_floats_of_a_broken_driver_are_cut_off() -> None:
    loud = np.array([3e38, -3e38, 0.5, 1.0], np.float32)
    assert to_int16(loud).tolist() == [32767, -32768, 16384, 32767]
