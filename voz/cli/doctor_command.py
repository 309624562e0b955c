"""`voz doctor`: checks what a robot needs, and says what to do."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import CommonOptions, DeviceOption, with_options
from voz.cli.text_io import show, show_raw
from voz.errors import ConfigError
from voz.process.signals import NOT_WELL

if TYPE_CHECKING:
    from voz.apps.doctor.finding import Finding

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
