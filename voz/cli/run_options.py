"""The options of `voz run`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from voz.cli.options import DeviceOption, ProfileOption, RecognizerOptions, ZeroconfOption
from voz.config import Config
from voz.errors import ConfigError
from voz.extras import require
from voz.process.setup import LEAST_MEMORY, LIVE_MEMORY
from voz.robot.kinds import ROBOTS

WEB_PACKAGES = ("starlette", "uvicorn", "websockets", "segno", "cryptography")

LOCAL = "127.0.0.1"
"""Only this computer reaches the page there."""

WebPortOption = Annotated[int, typer.Option(metavar="N", min=0, max=65535, help="Of the page.")]


def require_page() -> None:
    """Raise ConfigError if a package that a page needs is missing."""
    require("web", *WEB_PACKAGES)


@dataclass
class RunOptions(RecognizerOptions):
    """The options of `voz run`."""

    wav: Annotated[
        list[Path] | None, typer.Option(metavar="FILE", help="Recordings; may be repeated.")
    ] = None
    more: Annotated[
        list[Path] | None, typer.Argument(metavar="[FILE...]", help="More recordings.")
    ] = None
    text: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Typed commands, a line each.")
    ] = None
    replay: Annotated[
        Path | None, typer.Option(metavar="BAG", help="What a bag has on recognizer/output.")
    ] = None
    robot: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help=f"{', '.join(ROBOTS)} or MODULE:CLASS; may be repeated.",
        ),
    ] = None
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Recordings and text at their own pace.")
    ] = False
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the simulator's way, .png or .svg.")
    ] = None
    animation: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Show the simulator move, .gif or .mp4.")
    ] = None
    bag: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Keep what is published: .mcap, .db3, .bag, or none."),
    ] = None
    events: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Write all events as JSON lines.")
    ] = None
    no_sound: Annotated[bool, typer.Option("--no-sound", help="Do not speak.")] = False
    no_half_duplex: Annotated[
        bool, typer.Option("--no-half-duplex", help="Listen while the robot speaks: a headset.")
    ] = False
    no_safety: Annotated[
        bool, typer.Option("--no-safety", help="The bare command rules: docs/safety.md.")
    ] = False
    watchdog: Annotated[
        bool,
        typer.Option(
            "--watchdog/--no-watchdog",
            help="Stop ros1, ros2 and your own robots from another process if this one hangs.",
        ),
    ] = True
    device: DeviceOption = None
    listening: Annotated[
        bool, typer.Option("--listening", help='Obey from the start, without "start speech".')
    ] = False
    record: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Keep what is heard, for a test set of your own."),
    ] = None
    web: Annotated[
        bool, typer.Option("--web", help="Serve a page: see the robot, drive it, speak to it.")
    ] = False
    web_host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS", help="Where others reach the page, 0.0.0.0 for all; with a token."
        ),
    ] = LOCAL
    web_port: WebPortOption = 8737
    https: Annotated[
        bool, typer.Option("--https", help="Encrypt the page: for a phone's microphone.")
    ] = False
    listen_ros: Annotated[
        bool, typer.Option("--listen-ros", help="Obey another recognizer on ROS 2, too.")
    ] = False
    wyoming: Annotated[
        str | None,
        typer.Option(
            metavar="URI", help="Obey Home Assistant at tcp://HOST:PORT, by the Wyoming protocol."
        ),
    ] = None
    zeroconf: ZeroconfOption = True
    profile: ProfileOption = None
    adapt: Annotated[bool, typer.Option("--adapt", hidden=True)] = False

    @property
    def recordings(self) -> list[Path]:
        """The recordings that drive the robot."""
        return [*(self.wav or []), *(self.more or [])]

    @property
    def live(self) -> bool:
        """Whether the microphone drives the robot."""
        return not (self.recordings or self.text or self.replay)

    @property
    def least_memory(self) -> int:
        """The address space that the run needs, kB."""
        return LIVE_MEMORY if self.live else LEAST_MEMORY

    def check(self) -> None:
        """Refuse options that exclude each other."""
        if sum(map(bool, (self.recordings, self.text, self.replay))) > 1:
            raise ConfigError(
                "say what to obey: either --wav FILE... or --text FILE or --replay BAG"
            )
        if self.record and not self.live:
            raise ConfigError("--record keeps what a microphone hears: leave out --wav and --text")
        if self.web and not self.live:
            raise ConfigError("--web shows a live run: leave out --wav, --text and --replay")
        if self.listen_ros and not self.live:
            raise ConfigError("--listen-ros is for live runs: leave out --wav, --text and --replay")
        if self.wyoming and not self.live:
            raise ConfigError("--wyoming is for live runs: leave out --wav, --text and --replay")
        if (self.https or self.web_host != LOCAL) and not self.web:
            raise ConfigError("--web-host and --https are for the operator page: add --web")

    def check_service(self, settings: Config) -> None:
        """Refuse a service that cannot be, or that drives without safety rules."""
        if self.wyoming:
            require("wyoming", "wyoming", "zeroconf")
            if not settings.safety.enabled:
                raise ConfigError(
                    "--wyoming drives a robot that nobody watches: leave the safety rules on"
                )

    def check_outputs(self, settings: Config) -> None:
        """Refuse results that would replace what is read."""
        self.check_written(
            settings,
            [self.events, self.picture, self.animation, self.bag],
            [*self.recordings, self.text, self.replay, self._profile()],
        )

    def _profile(self) -> Path | None:
        if self.profile is None:
            return None
        from voz.recognition.profiles import profile_folder

        return profile_folder(self.profile)

    def settings(self, **others: Any) -> Config:
        """As for all, with what the robot may do."""
        return super().settings(
            safety={"enabled": False if self.no_safety else None},
            speech={
                "enabled": False if self.no_sound else None,
                "half_duplex": False if self.no_half_duplex else None,
            },
            robot=self.robot or None,
            **others,
        )
