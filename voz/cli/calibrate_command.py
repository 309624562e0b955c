"""`voz calibrate`: a profile of a speaker."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import CommonOptions, DeviceOption, with_options
from voz.cli.text_io import show


@with_options
def calibrate(
    options: CommonOptions,
    *,
    name: Annotated[str, typer.Argument(metavar="[NAME]", help="Of the profile.")] = "default",
    wav: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Recordings with a manifest.tsv; else a microphone."),
    ] = None,
    device: DeviceOption = None,
    list_profiles: Annotated[
        bool, typer.Option("--list", help="Show the names of all profiles.")
    ] = False,
    delete: Annotated[
        bool, typer.Option("--delete", help="Delete the profile and its recordings.")
    ] = False,
) -> None:
    """Get to know a speaker and a microphone in two minutes.

    Shows commands to say and what is heard, keeps the recordings, and finds out what helps to
    understand them. What is heard wrongly is asked for once more.
    `voz run --profile NAME` and `voz decode --profile NAME` use it. Ctrl-C stops, and the same
    call goes on.

    Example: voz calibrate ana
    """
    from voz.recognition.speaker import profiles

    if list_profiles:
        show(*profiles.profile_names())
    elif delete:
        profiles.delete_profile(name)
    else:
        from voz.cli.make_profile import make_profile
        from voz.process.standard_streams import quiet_libraries

        settings = options.settings()
        with quiet_libraries():
            make_profile(name, wav, device, options.language(settings), settings.recognition)
