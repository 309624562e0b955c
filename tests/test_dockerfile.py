"""The Dockerfile, which no test can build: that it agrees with what it is made from."""

from __future__ import annotations

import re
import subprocess

from recordings import ROOT

TEXT = (ROOT / "Dockerfile").read_text()
LINES = re.sub(r"\\\n", " ", re.sub(r"^\s*#.*\n", "", TEXT, flags=re.MULTILINE)).splitlines()


def instructions(name: str) -> list[str]:
    return [line.split(maxsplit=1)[1] for line in LINES if line.startswith(f"{name} ")]


def packages() -> set[str]:
    (command,) = [run for run in instructions("RUN") if "apt-get install" in run]
    names = command.split("--no-install-recommends")[1].split("&&")[0].split()
    return set(names)


def test_it_installs_what_the_installation_installs() -> None:
    script = (ROOT / "tools" / "install.sh").read_text()
    first = re.search(r'^packages="(.*)"$', script, re.MULTILINE)
    assert first
    assert set(first[1].split()) <= packages()


def test_every_package_is_one_of_debian() -> None:
    # All of them are installed here by `sh tools/install.sh tests`.
    done = subprocess.run(
        ["dpkg-query", "--show", "--showformat=${Package}\n", *sorted(packages())],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == packages()


def test_what_is_copied_is_there_and_not_ignored() -> None:
    kept = {line[1:] for line in (ROOT / ".dockerignore").read_text().split() if line[0] == "!"}
    copied = {name for line in instructions("COPY") for name in line.split()[:-1]}
    assert copied == kept
    assert all((ROOT / name).exists() for name in copied)


def test_it_does_not_run_as_root_and_starts_voz() -> None:
    assert instructions("USER") == ["robot"]
    assert instructions("ENTRYPOINT") == ['["voz"]']
    assert TEXT.index("\nUSER") > TEXT.rindex("\nRUN")
