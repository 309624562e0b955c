"""`voz service`: lets voz start with the computer."""

from __future__ import annotations

from typing import Annotated

import typer

from voz.cli.options import CommandGroup, with_options
from voz.cli.run_options import RunOptions
from voz.cli.text_io import show, show_raw
from voz.process.signals import NOT_WELL

service = typer.Typer(
    cls=CommandGroup,
    rich_markup_mode=None,
    help="Let voz start with the computer, as a service of systemd's.",
)


@service.command("install")
def install(
    options: Annotated[
        list[str] | None, typer.Argument(metavar="[-- OPTIONS]", help="Those of `voz run`.")
    ] = None,
    shown: Annotated[
        bool, typer.Option("--print", help="Show the unit, and write nothing.")
    ] = False,
) -> None:
    """Let voz drive the robot from now on, and whenever the computer starts.

    It runs in the folder that you are in, whose voz.toml and lm/ it reads, with what is set here
    for ROS. If it fails it is started again. Without a display it writes lines into the journal.

    Example: voz service install -- --robot console,ros2 --listening
    """
    from voz.apps.service import systemd

    _check(options or [])
    if shown:
        show_raw(systemd.unit_for(options or []).rstrip("\n"))
        return
    for done in systemd.install(options or []):
        show(done)


@service.command("uninstall")
def uninstall() -> None:
    """Stop voz, and do not start it again.

    Example: voz service uninstall
    """
    from voz.apps.service import systemd

    for done in systemd.uninstall():
        show(done)


@service.command("status")
def status() -> None:
    """Show whether it runs, and its last lines; the exit code is 1 if it does not.

    Example: voz service status
    """
    from voz.apps.service import systemd

    told, runs = systemd.status()
    show(*told.splitlines())
    if not runs:
        raise typer.Exit(NOT_WELL)


def _check(options: list[str]) -> None:
    """Refuse now what `voz run` would refuse later, when only the journal shows it."""
    from typer.main import get_command

    checked = typer.Typer(add_completion=False)
    checked.command()(with_options(_look_at))
    run = get_command(checked)
    with run.make_context("voz run", list(options)) as context:
        run.invoke(context)


def _look_at(options: RunOptions) -> None:
    """Refuse names of missing files and devices; nothing is opened."""
    from voz.recognition.profiles import load_profile
    from voz.robot.factory import robot_names

    options.check()
    settings = options.settings()
    options.check_outputs(settings)
    robot_names(settings.robot)
    options.language(settings)
    if options.profile:
        load_profile(options.profile)
