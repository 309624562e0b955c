"""The subcommands, and the start and end of the program."""

from __future__ import annotations

import logging
import signal
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from voz import __version__
from voz.cli.audio_commands import devices, say, sound
from voz.cli.build_lm_command import build_lm
from voz.cli.calibrate_command import calibrate
from voz.cli.decode_command import decode, merge
from voz.cli.eval_command import evaluate, fit_confidence
from voz.cli.language_commands import commands, languages, parse
from voz.cli.options import CommandGroup
from voz.cli.run_command import run
from voz.cli.serve_commands import serve, view
from voz.cli.setup_commands import doctor, new, service
from voz.cli.text_io import info, show, writing_results
from voz.errors import CommandsError, RobotMistake, VozError
from voz.process.signals import SIGNAL_EXIT_CODE, WRONG_CALL

UsageError: Any = typer.BadParameter.__mro__[1]  # typer's own or click's, as its version has it

app = typer.Typer(
    cls=CommandGroup,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # the plain help takes half the time
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Offline voice control for robots: speak a command, the robot moves and answers. "
    "The commands are English; `voz language` takes another.",
)


def _show_version(asked: bool) -> None:
    if asked:
        show(f"voz {__version__}")
        raise typer.Exit


@app.callback()
def _before_all(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None: ...


# The help shows them in this order.
app.command("new")(new)
app.command("build-lm")(build_lm)
app.command("commands")(commands)
app.command("parse")(parse)
app.add_typer(languages, name="language")
app.command("decode")(decode)
app.command("merge")(merge)
app.command("eval")(evaluate)
app.command("fit-confidence")(fit_confidence)
app.command("run")(run)
app.command("view")(view)
app.command("serve")(serve)
app.command("calibrate")(calibrate)
app.command("devices")(devices)
app.command("doctor")(doctor)
app.add_typer(service, name="service")
app.command("say")(say)
app.command("sound")(sound)


def call(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code. None takes the arguments of the process."""
    logging.lastResort = logging.NullHandler()  # users need no log of libraries
    given = sys.argv[1:] if arguments is None else arguments
    try:
        # Not typer's no_args_is_help, which is an error in one version of it and none in another.
        code = app(args=given or ["--help"], prog_name="voz", standalone_mode=False)
        with writing_results():
            sys.stdout.flush()
    except (BrokenPipeError, SystemExit) as end:  # as in `voz decode ... | head -1`
        # click itself notices a broken pipe, too, and ends with 1, which is `STALE`.
        if BrokenPipeError not in (type(end), type(end.__context__)):
            raise
        return SIGNAL_EXIT_CODE + signal.SIGPIPE
    except CommandsError as error:
        code = _wrong_call(str(error))
        for line in error.excerpt:
            info(f"  {line}")
        return code
    except (VozError, OSError) as error:
        if isinstance(error, RobotMistake) and {"-v", "--verbose"} & set(given):
            for line in "".join(traceback.format_exception(error.__cause__)).splitlines():
                info(line)
        return _wrong_call(str(error))
    except UsageError as error:
        return _wrong_call(error.format_message())
    return code if isinstance(code, int) else 0


def _wrong_call(message: str) -> int:
    info(f"voz: {message}")
    return WRONG_CALL
