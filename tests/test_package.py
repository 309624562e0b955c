"""What is installed works without the checkout beside it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest
from calls import VOZ
from recordings import FIXTURES, ROOT

from voz.language.language_files import PACKAGED_FOLDER


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The content of the wheel, in a folder by itself."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, ROOT]
    subprocess.run(command, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(folder / "installed")
    return folder / "installed"


def voz(installed: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*VOZ, *map(str, arguments)],
        cwd=installed.parent,
        env=os.environ | {"PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
        check=True,
    )


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.slow
def test_the_language_files_travel_in_the_package(installed: Path) -> None:
    assert contents(installed / "voz" / "lm") == contents(ROOT / "lm")
    for language in ("es", "fr"):
        there = contents(installed / "voz" / "lm" / language)
        assert there == contents(PACKAGED_FOLDER / language) != {}


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A clone whose list somebody has changed."""
    for name in ("lm", "voz"):
        shutil.copytree(ROOT / name, tmp_path / "clone" / name, symlinks=True)
    with (tmp_path / "clone" / "lm" / "comandos_voz.txt").open("a") as file:
        file.write("stop peach\n")
    return tmp_path / "clone"


@pytest.mark.slow
def test_a_list_that_is_edited_in_a_clone_is_warned_of_and_known_there_alone(clone: Path) -> None:
    (elsewhere := clone.parent / "empty").mkdir()
    environment = os.environ | {"PYTHONPATH": str(clone)}

    def call(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*VOZ, *arguments], cwd=folder, env=environment, capture_output=True, text=True
        )

    built = call(clone, "build-lm")
    assert '"stop speech" and "stop peach" sound alike' in built.stderr
    here, there = (call(folder, "parse", "stop peach").stdout for folder in (clone, elsewhere))
    assert here == '"stop peach": stop peach\n'
    assert there == '"stop peach": no command; did you mean "stop speech"?\n'


@pytest.mark.slow
def test_an_older_voz_is_gone_once_it_is_installed_again(tmp_path: Path) -> None:
    for name in ("pyproject.toml", "constraints.txt", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path)
    for name in ("lm", "tools", "voz"):
        shutil.copytree(ROOT / name, tmp_path / name, symlinks=True)
    subprocess.run([sys.executable, "-m", "venv", tmp_path / ".venv"], check=True)
    (packages,) = (tmp_path / ".venv" / "lib").glob("python*/site-packages")
    (packages / "others.pth").write_text(f"{sysconfig.get_path('purelib')}\n")  # all but voz
    old = packages / "voz-0.1.0.dist-info"
    old.mkdir()
    (old / "METADATA").write_text("Metadata-Version: 2.1\nName: voz\nVersion: 0.1.0\n")
    (old / "INSTALLER").write_text("pip\n")
    files = ("METADATA", "INSTALLER", "RECORD")
    (old / "RECORD").write_text("".join(f"{old.name}/{name},,\n" for name in files))
    subprocess.run(["sh", tmp_path / "tools" / "install.sh"], check=True, capture_output=True)
    command = [tmp_path / ".venv/bin/python", "-m", "pip", "list", "--format=freeze"]
    done = subprocess.run([*command, "--path", packages], check=True, capture_output=True)
    named = [line for line in done.stdout.decode().splitlines() if line.startswith("voz")]
    assert named == ["voz-robot==0.1.0"]
    assert (tmp_path / ".venv" / "bin" / "voz").exists()


@pytest.mark.slow
def test_an_installed_voz_understands_commands(installed: Path) -> None:
    clip = FIXTURES / "commands" / "festival_slt__go_back.flac"
    done = voz(installed, "decode", "--json", "--search", "grammar", clip)
    assert json.loads(done.stdout)["text"] == "go back"


@pytest.mark.slow
def test_an_installed_voz_uses_its_own_files_where_there_are_no_others(installed: Path) -> None:
    typed = installed.parent / "typed.txt"
    typed.write_text("stop\n")
    done = voz(installed, "run", "-v", "--no-sound", "--text", typed)
    assert f"language files: {installed / 'voz' / 'lm'}" in done.stderr
