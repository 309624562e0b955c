"""`voz parse`: what a sentence means."""

from __future__ import annotations

from typing import Annotated

import typer

from voz.cli.options import CommonOptions, with_options
from voz.cli.text_io import show, show_raw


@with_options
def parse(
    options: CommonOptions,
    texts: Annotated[list[str], typer.Argument(metavar="TEXT...", help="What would be said.")],
    as_json: Annotated[bool, typer.Option("--json", help="One line of JSON for each.")] = False,
) -> None:
    """Show what sentences mean: their command and slots, or which command is nearest.

    Example: voz parse "go forward" "go forwards"
    """
    import msgspec

    from voz.language.language_files import read_commands

    commands = read_commands(options.language(options.settings()))
    for text in texts:
        found = commands.parse(text)
        meant = None if found else commands.closest_sentence(text)
        if as_json:
            fields = {
                "text": found.text if found else text,
                "command": found.command if found else None,
                "slots": dict(found.slots) if found else {},
            }
            show_raw(msgspec.json.encode(fields | ({"meant": meant} if meant else {})).decode())
        elif found:
            slots = "".join(f"  {name}={value}" for name, value in found.slots.items())
            show(f'"{found.text}": {found.command}{slots}')
        else:
            show(f'"{text}": no command' + (f'; did you mean "{meant}"?' if meant else ""))
