"""The exit codes besides 0; from 128 on it was a signal, see `voz.process.signals`."""

STALE = 1
"""Exit code of `build-lm --check` when files are not up to date."""

NOT_WELL = 1
"""Exit code of `doctor` when something that is needed is not well."""

WRONG_CALL = 2
"""Exit code when an option, a file or a text cannot be used."""

SOME_UNREADABLE = 3
"""Exit code when some recordings could not be read; the others are done."""
