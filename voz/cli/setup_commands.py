"""`voz new`, `voz doctor` and `voz service`: begin a robot, check it, start it by systemd."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import CommandGroup, CommonOptions, DeviceOption, with_options
from voz.cli.run_options import RunOptions
from voz.cli.text_io import info, show, show_raw
from voz.errors import ConfigError
from voz.process.signals import NOT_WELL

if TYPE_CHECKING:
    from voz.apps.doctor.finding import Finding

FILES_ARE = {
    "commands.txt": "what may be said",
    "voz.toml": "what the commands do, and the settings",
    "my_robot.py": "the robot",
    "test_my_robot.py": "its test",
}


def new(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Where; a new one.")],
    robot_type: Annotated[
        str,
        typer.Option("--type", metavar="python|serial|ros1|ros2", help="How it is driven."),
    ] = "python",
) -> None:
    """Begin a robot of your own: a folder in which `voz run` works at once.

    It has a list of commands, a voz.toml, a test, and the class of a robot that prints what its
    motors should do (`python`) or writes it to a serial port (`serial`); with ROS the robot is
    voz's own.

    Example: voz new robot
    """
    from voz.apps.starter.robot_folder import make_robot_folder
    from voz.files import shown_path

    for path in make_robot_folder(folder, robot_type):
        show(f"{shown_path(path)}: {FILES_ARE[path.name]}")
    info(f"go on with: cd -- {shlex.quote(shown_path(folder))}; voz run")


CONFIRM_DRIVING = (
    "The base will turn on the spot at 0.2 rad/s, for up to 2.5 s. "
    "Is it free, and a hand at its switch?"
)


@with_options
def doctor(
    options: CommonOptions,
    *,
    robot: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Which robot is needed, as `voz run` takes it."),
    ] = None,
    base: Annotated[
        bool, typer.Option("--base", help="Also DRIVE the base, to see whether it stops by itself.")
    ] = False,
    odom: Annotated[
        str | None,
        typer.Option(metavar="TOPIC", help="The base's odometry; else as in voz.toml."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the base moves.")] = False,
    json: Annotated[bool, typer.Option("--json", help="A JSON object a line.")] = False,
    device: DeviceOption = None,
) -> None:
    """Look whether all is there that a robot needs to obey, and tell what to do.

    Nothing moves without --base. The exit code is 1 if something that is needed is not well.

    Example: voz doctor --robot ros2
    """
    from voz.process.standard_streams import quiet_libraries
    from voz.robot.factory import robot_names

    settings = options.settings(robot=robot or None)
    robots = robot_names(settings.robot)
    driven = _base_to_drive(robots, yes) if base else None
    well = True
    with quiet_libraries():
        from voz.apps.doctor.all_checks import check_all, check_base_stops

        for finding in check_all(settings, robots, device):
            well = _show(finding, json) and well
        if driven:
            well = _show(check_base_stops(settings, driven, odom), json) and well
    if not well:
        raise typer.Exit(NOT_WELL)


def _base_to_drive(robots: Sequence[str], yes: bool) -> str:
    """Return the robot whose base is to be driven, if somebody confirms it."""
    possible = [name for name in robots if name in ("ros1", "ros2")]
    if len(possible) != 1:
        raise ConfigError("--base drives one base: add --robot ros1 or --robot ros2")
    if not (yes or sys.stdin.isatty()):
        raise ConfigError("--base moves the robot, and nobody can be asked here: add --yes")
    if not (yes or typer.confirm(CONFIRM_DRIVING, err=True)):
        raise ConfigError("the base was not driven; leave out --base to look at the rest")
    return possible[0]


def _show(finding: Finding, json: bool) -> bool:
    """Show a finding; return whether the robot works with it."""
    from voz.events import to_json

    if json:
        show_raw(to_json(finding))
    else:
        mark = "ok" if finding.ok else "NO" if finding.required else "--"
        show(f"{mark}  {finding.part + ':':22} {finding.status}")
        if finding.remedy:
            show(f"{'':27}{finding.remedy}")
    return finding.ok or not finding.required


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
    from voz.apps import systemd

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
    from voz.apps import systemd

    for done in systemd.uninstall():
        show(done)


@service.command("status")
def status() -> None:
    """Show whether it runs, and its last lines; the exit code is 1 if it does not.

    Example: voz service status
    """
    from voz.apps import systemd

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
