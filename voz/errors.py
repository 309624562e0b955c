"""Everything that can go wrong, as one family.

    VozError
    ├── ConfigError      voz.toml, an option or an argument holds what cannot be
    ├── CommandsError    the command list, or a pronunciation, cannot be used
    ├── LanguageError    the generated language files are missing or broken
    ├── AudioError       a recording or a sound device cannot be read or opened
    ├── SpeechError      a text cannot be spoken
    ├── RecognizerBusyError  a signal handler calls a recognizer amid another call
    ├── ServiceError     the system does not run voz as a service
    └── RobotError       a robot cannot be reached
        └── RobotMistake its own code raised something

Every message is one line, which any terminal can show and JSON can hold: what was wrong, where,
and what to do. The command line prints it and exits with 2.
"""

from voz.printable import shown_text


class VozError(Exception):
    """Base of all errors that voz raises on purpose.

    Attributes:
        problem: what was wrong, and where.
        remedy: what to do, if anything can be done.
    """

    def __init__(self, problem: object, remedy: str | None = None) -> None:
        """Make an error whose text is the problem, then the remedy after a semicolon.

        Args:
            problem: if it comes without `remedy`, what follows its first semicolon is the remedy.
            remedy: to be given where the problem quotes a text that may hold a semicolon.
        """
        text = shown_text(problem)
        if remedy is None:
            self.problem, _, found = text.partition("; ")
            self.remedy = found or None
        else:
            self.problem, self.remedy = text, shown_text(remedy)
            text = f"{text}; {self.remedy}"
        super().__init__(text)


class ConfigError(VozError, ValueError):
    """A setting in voz.toml, an option or an argument is invalid.

    It is a ValueError, so that msgspec adds the place in a file.
    """


class CommandsError(VozError):
    """The command list or a pronunciation cannot be used.

    Attributes:
        excerpt: the line with a caret below the error, if that helps.
    """

    def __init__(
        self, problem: object, remedy: str | None = None, excerpt: tuple[str, ...] = ()
    ) -> None:
        super().__init__(problem, remedy)
        self.excerpt = tuple(map(shown_text, excerpt if isinstance(excerpt, tuple | list) else ()))


class LanguageError(VozError):
    """The generated language files are missing or do not belong together."""


class AudioError(VozError):
    """A recording or a sound device cannot be used."""


class SpeechError(VozError):
    """A text cannot be turned into speech."""


class RecognizerBusyError(VozError):
    """A signal handler called a recognizer during another call."""


class ServiceError(VozError):
    """The system's service manager is missing or refuses."""


class RobotError(VozError):
    """A robot cannot be reached or does not do what it should."""


class RobotMistake(RobotError):
    """A user's own code for a robot raised the error that is the cause."""
