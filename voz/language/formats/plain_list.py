"""The plain command list: one sentence a line; pure."""

from __future__ import annotations

from dataclasses import dataclass

from voz.errors import CommandsError
from voz.language.formats.text_lines import content_lines, summarize_warnings
from voz.language.sentences.spelling import find_unspeakable, length_complaint, normalize

MAX_COMMAND_WORDS = 12


@dataclass(frozen=True)
class CommandList:
    """The sentences of a plain list.

    Attributes:
        name: what messages call the list, mostly its path.
        sentences: the commands, normalized, each once, in the order of the list.
        lines: the line number of each sentence, from 1.
        warnings: what the user should know, one line each.
    """

    name: str
    sentences: tuple[str, ...]
    lines: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    def places(self) -> dict[str, str]:
        """Where each word first stands, as `FILE:LINE`."""
        places: dict[str, str] = {}
        for sentence, line in zip(self.sentences, self.lines, strict=True):
            for word in sentence.split():
                if word not in places:
                    places[word] = f"{self.name}:{line}"
        return places


def parse_commands(data: bytes, name: str) -> CommandList:
    """Parse a command list, UTF-8: one sentence a line, `#` begins a comment.

    Messages call it `name`. Raises CommandsError.
    """
    lines: dict[str, int] = {}
    repeats: list[str] = []
    for number, text in content_lines(data, name):
        _check_sentence(text, f"{name}:{number}")
        sentence = normalize(text)
        first = lines.setdefault(sentence, number)
        if first != number:
            repeats.append(
                f'{name}:{number}: "{sentence}" is repeated (first in line {first}); kept once'
            )
    if not lines:
        raise CommandsError(f"{name}: contains no command; write one sentence per line")
    summary = f"{name}: {len(repeats)} lines repeat an earlier one; each sentence is kept once"
    return CommandList(
        name, tuple(lines), tuple(lines.values()), summarize_warnings(repeats, summary)
    )


def _check_sentence(text: str, where: str) -> None:
    if found := find_unspeakable(text):
        raise CommandsError(f"{where}: {found[1]}")
    words = text.split()
    if len(words) > MAX_COMMAND_WORDS:
        raise CommandsError(
            f"{where}: has {len(words)} words; at most {MAX_COMMAND_WORDS} are allowed"
        )
    if advice := length_complaint(max(words, key=len)):
        raise CommandsError(f"{where}: {advice}")
