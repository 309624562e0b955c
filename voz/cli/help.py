"""How the help lists subcommands."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

MAX_SUMMARY_LENGTH = 1000
"""Characters of the first sentence of a subcommand's help; typer would cut it at the line's end."""


class CommandGroup(TyperGroup):
    """Subcommands, each listed with its whole summary, on several lines if need be."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of the subcommands."""
        commands = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, command.get_short_help_str(MAX_SUMMARY_LENGTH))
                    for name, command in commands
                    if command and not command.hidden
                ]
            )
