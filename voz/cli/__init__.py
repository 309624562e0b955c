"""The `voz` command: a module for each group of subcommands, which read options and call voz.

What takes its time to import is imported inside the subcommand that needs it, so that
`voz --help` is there at once.
"""

from voz.cli.app import main

__all__ = ["main"]
