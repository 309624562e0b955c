"""Lines that three jobs take with voz and beside it: python benchmarks/lines_of_code.py.

The programs are in `lines_of_code/`. Blank lines, comments and docstrings are not counted; imports
are, and so are the lines of a file that a program reads beside the recording.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

PROGRAMS = Path(__file__).parent / "lines_of_code"

JOBS = {
    "file": "print what is said in a recording",
    "microphone": "print what is said into the microphone",
    "list": "the same, of a list of three commands",
}

LIBRARIES = ("voz", "pocketsphinx", "speech_recognition", "vosk")


def count(path: Path) -> int:
    """The lines of a file that are neither blank nor a comment nor a docstring."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return sum(1 for line in text.splitlines() if line.strip())
    left_out = {number for docstring in _docstrings(text) for number in docstring}
    return sum(
        1
        for number, line in enumerate(text.splitlines(), start=1)
        if number not in left_out and line.strip() and not line.lstrip().startswith("#")
    )


def _docstrings(text: str) -> Iterator[Sequence[int]]:
    """The numbers of the lines of each docstring."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield range(node.lineno, (node.end_lineno or node.lineno) + 1)


def lines(job: str, library: str) -> int:
    """The lines of a job with a library, of all files that it needs."""
    files = [*PROGRAMS.glob(f"{job}_{library}.*")]
    assert files, (job, library)
    return sum(map(count, files))


def table() -> str:
    """The table of `docs/why.md`."""
    rows = [
        ["job", "voz", "pocketsphinx", "SpeechRecognition", "vosk"],
        ["---"] * (len(LIBRARIES) + 1),
        *(
            [told, *(str(lines(job, library)) for library in LIBRARIES)]
            for job, told in JOBS.items()
        ),
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


if __name__ == "__main__":
    print(table())
