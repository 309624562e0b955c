"""Broken input of many kinds: one line for each, the right exit code, never a traceback."""

from __future__ import annotations

import json
import random
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
import soundfile
from calls import VOZ
from language.damage import damaged
from recordings import FIXTURES, ROOT

from voz.apps.evaluation.report import evaluate, read_results
from voz.apps.evaluation.results import Result, Understood
from voz.apps.recordings.manifest import read_manifest
from voz.config import load_config
from voz.errors import VozError
from voz.recognition.profiles import Profile, load_profile, save_profile

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


def toml(folder: Path) -> tuple[Path, Callable[[], object]]:
    page = (ROOT / "docs" / "settings.md").read_text()
    (settings,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    path = folder / "voz.toml"
    path.write_text(settings)
    return path, lambda: load_config(path)


def manifest(folder: Path) -> tuple[Path, Callable[[], object]]:
    path = folder / "manifest.tsv"
    lines = (FIXTURES / "manifest.tsv").read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:40]))
    return path, lambda: read_manifest(path)


def comparison(folder: Path) -> tuple[Path, Callable[[], object]]:
    heard = (Understood("stop", 0.5, accepted=True),)
    results = [
        Result("set", f"{n}.wav", "stop", "ann", "command", "all", heard=heard) for n in "ab"
    ]
    path = folder / "results.json"
    path.write_bytes(msgspec.json.encode({"results": results}))
    return path, lambda: evaluate(results, {}, read_results(path))


def profile(folder: Path) -> tuple[Path, Callable[[], object]]:
    path = save_profile("ann", Profile(0.5, "0" * 64))
    return path, lambda: load_profile("ann")


@pytest.mark.parametrize("kind", [toml, manifest, comparison, profile])
def test_fuzzed_files_of_other_kinds(
    kind: Callable[[Path], tuple[Path, Callable[[], object]]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    path, read = kind(tmp_path)
    read()
    data, refused, taken = path.read_bytes(), 0, 0
    for seed in range(FILES):
        path.write_bytes(damaged(data, random.Random(seed)))
        try:
            read()
        except VozError as error:
            refused += str(error).isprintable()
        else:
            taken += 1
    assert refused + taken == FILES
    assert refused >= FILES // 4
