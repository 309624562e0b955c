"""Types what README and the lesson show, in a fresh clone, and times each step.

Run `make hour`, or `python3 tools/first_hour.py` with any Python. It prints what a stranger reads,
in minutes at 200 words a minute, and how long the computer takes, s. Whoever types and speaks takes
longer. The clone is in a temporary folder, and is deleted.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent

BLOCK = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)

LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")

WORDS_A_MINUTE = 200

LISTENS_WITHIN = 30.0
"""The page answers after its start, s."""

PAGE = "http://127.0.0.1:8737/"


def parts(path: Path) -> Iterator[tuple[str, str]]:
    """Yield heading and text of each part of a page."""
    for part in re.split(r"^## ", path.read_text(encoding="utf-8"), flags=re.MULTILINE):
        heading, _, text = part.partition("\n")
        yield heading.removeprefix("# "), text


def minutes(text: str) -> float:
    """How long a text takes to read, without its blocks."""
    plain = LINK.sub(r"\1", BLOCK.sub("", text)).replace("|", "")
    return len(plain.split()) / WORDS_A_MINUTE


def typed(commands: str, folder: Path) -> Path:
    """Type commands in a folder; returns the one that they end in, and exits if one fails."""
    call = ["sh", "-ec", f"{commands}\npwd"]
    done = subprocess.run(call, cwd=folder, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"{done.stdout}{commands}\nfailed in {folder}")
    return Path(done.stdout.splitlines()[-1])


def save(language: str, block: str, folder: Path) -> None:
    """Save a program or some settings of the lesson, as it says."""
    if language == "python":
        (folder / block.split()[1]).write_text(block, encoding="utf-8")
    elif language == "toml":
        settings = folder / "voz.toml"
        head, lines = block.split("\n", 1)
        head = head.partition("  #")[0] + "\n"
        settings.write_text(settings.read_text().replace(head, head + lines))


def shows_its_page(clone: Path) -> None:
    """Start a simulated robot with a page, and wait for it."""
    options = "--robot simulator --web --device browser --no-sound"
    call = [str(clone / ".venv/bin/voz"), "run", *options.split()]
    with subprocess.Popen(call, stdout=subprocess.DEVNULL) as robot:
        until = time.monotonic() + LISTENS_WITHIN
        while True:
            try:
                urllib.request.urlopen(PAGE).close()
                break
            except OSError:
                if time.monotonic() > until or robot.poll() is not None:
                    sys.exit(f"{PAGE} does not answer")
                time.sleep(0.1)
        robot.terminate()


def steps(clone: Path) -> Iterator[tuple[str, float]]:
    """Do one step after the other; yields its name, and what is read for it, minutes."""
    typed(f"git clone --quiet {ROOT} {clone}", clone.parent)
    yield "clone", 0
    readme = dict(parts(ROOT / "README.md"))
    typed("make demo", clone)
    yield "README: `make demo`", minutes("".join(text for _, text in parts(ROOT / "README.md")))
    voz = f'PATH="{clone}/.venv/bin:$PATH"; '
    typed(f"{voz}voz run --wav audio_fixtures/long/session.wav --no-sound", clone)
    yield "a recording drives", 0
    typed(f'{voz}echo "open gripper" >> lm/comandos_voz.txt; voz build-lm', clone)
    yield "a command of your own", 0
    ((_, program),) = BLOCK.findall(readme["Your robot"])
    (clone / "wheels.py").write_text(program, encoding="utf-8")
    lines = "start speech\\ngo forward\\n-\\n-\\nstop\\n-\\n"
    typed(f"{voz}printf '{lines}' | voz run --robot wheels:Wheels --no-sound --text -", clone)
    yield "a robot of your own", 0
    typed("make web", clone)
    shows_its_page(clone)
    yield "the page in a browser", 0
    folder = clone
    for heading, text in parts(ROOT / "docs" / "lesson.md"):
        for language, block in BLOCK.findall(text):
            if language == "sh":
                folder = typed(voz + block, folder)
            save(language, block, folder)
        yield f"lesson: {heading.partition(' (')[0]}", minutes(text)


def main() -> None:
    """Print the steps as a table."""
    print("| step | read, min | the computer takes, s |\n|---|---|---|")
    begun = last = time.monotonic()
    read = 0.0
    with tempfile.TemporaryDirectory(prefix="voz-hour-") as folder:
        for name, reading in steps(Path(folder) / "voz"):
            now = time.monotonic()
            print(f"| {name} | {reading:.1f} | {now - last:.0f} |", flush=True)
            read, last = read + reading, now
    print(f"| all | {read:.1f} | {last - begun:.0f} |")


if __name__ == "__main__":
    main()
