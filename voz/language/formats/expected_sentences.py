"""`tests.txt` beside a list: sentences that must be commands, and those that must not; pure."""

from __future__ import annotations

from collections.abc import Iterator

from voz.language.formats.text_lines import content_lines
from voz.language.sentences.command_set import Commands

EXPECTED_SENTENCES_FILE = "tests.txt"

NEGATION = "!"
"""Before a sentence that must not be a command; alone on a line, before all that follow."""


def failed_expectations(commands: Commands, data: bytes, name: str) -> Iterator[str]:
    """Report each line whose expectation does not hold; raises CommandsError.

    The data has a sentence a line, UTF-8; messages call the file `name`.
    """
    none_follow = False
    for number, line in content_lines(data, name):
        text = line.strip()
        if text == NEGATION:
            none_follow = True
            continue
        wanted = not (none_follow or text.startswith(NEGATION))
        text = text.lstrip(NEGATION).strip()
        parse = commands.parse(text)
        if wanted and parse is None:
            meant = commands.closest_sentence(text)
            perhaps = f'; the nearest is "{meant}"' if meant else ""
            yield f'{name}:{number}: "{text}" should be a command, but is not{perhaps}'
        elif parse and not wanted:
            yield f'{name}:{number}: "{text}" should not be a command, but is "{parse.command}"'
