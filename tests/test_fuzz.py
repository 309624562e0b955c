"""Broken input of many kinds: one line for each, the right exit code, never a traceback."""

from __future__ import annotations

import json
import random
import subprocess
from pathlib import Path

import pytest
import soundfile
from calls import VOZ
from recordings import FIXTURES

from voz.errors import VozError
from voz.language.build import build

SOURCE = FIXTURES / "formats" / "mono_8000.wav"
FILES = 200


def fuzzed_header(data: bytes, seed: int) -> bytes:
    """A recording with some bytes of its header, or its length, changed."""
    chance = random.Random(seed)
    broken = bytearray(data[:20_000])
    for _ in range(chance.randint(1, 6)):
        broken[chance.randrange(48)] = chance.choice(
            [0, 1, 0x7F, 0x80, 0xFF, chance.randrange(256)]
        )
    return bytes(broken[: chance.choice([len(broken), chance.randrange(len(broken))])])


@pytest.mark.parametrize("subtype", ["PCM_16", "FLOAT"])
def test_fuzzed_wav_headers(subtype: str, tmp_path: Path) -> None:
    samples, rate = soundfile.read(SOURCE)
    original = tmp_path / "original.wav"
    soundfile.write(original, samples, rate, subtype)
    paths = [tmp_path / f"{seed}.wav" for seed in range(FILES)]
    for seed, path in enumerate(paths):
        path.write_bytes(fuzzed_header(original.read_bytes(), seed))
    done = subprocess.run(
        [*VOZ, "decode", "--json", *map(str, paths)],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 3, done.stderr
    assert done.stderr == ""
    results = [json.loads(line) for line in done.stdout.splitlines()]
    errors = [result["error"] for result in results if "error" in result]
    assert len(errors) >= FILES // 4
    assert all("\n" not in error for error in errors)


def test_fuzzed_command_lists(tmp_path: Path) -> None:
    data = b"start speech\nGo forward # here\r\n\xef\xbb\xbfstop\nturn left\n"
    refused = 0
    for seed in range(FILES):
        chance = random.Random(seed)
        broken = bytearray(data)
        for _ in range(chance.randint(1, 5)):
            broken[chance.randrange(len(broken))] = chance.randrange(256)
        path = tmp_path / "list.txt"
        path.write_bytes(broken)
        if message := refusal(path):
            refused += 1
            assert message.startswith(f"{path}:")
            assert "\n" not in message
    assert refused >= FILES // 4


def refusal(commands: Path) -> str | None:
    try:
        build(commands, commands.parent)
    except VozError as error:
        return str(error)
    return None
