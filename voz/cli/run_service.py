"""`voz run --wyoming`: other programs drive the robot of a live run."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from voz.cli.run_options import RunOptions
from voz.errors import ConfigError
from voz.extras import require

if TYPE_CHECKING:
    from voz.config import Config
    from voz.recognition.engine import RecognitionEngine
    from voz.run.live import CommandServiceMaker


def check_service(options: RunOptions, settings: Config) -> None:
    """Refuse, before the run, a service that cannot be, or that drives without safety rules."""
    if not options.wyoming:
        return
    require("wyoming", "wyoming", "zeroconf")
    if not settings.safety.enabled:
        raise ConfigError("--wyoming drives a robot that nobody watches: leave the safety rules on")


def service_of(options: RunOptions, recognizer: RecognitionEngine) -> CommandServiceMaker | None:
    """Return what makes the service of a run; None if it has none."""
    if not options.wyoming:
        return None
    from voz.apps.wyoming.robot_service import RobotService
    from voz.language.language_files import read_language_info

    language = read_language_info(recognizer.files).code
    return partial(
        RobotService,
        options.wyoming,
        lambda: recognizer.commands,
        language,
        announce=options.zeroconf,
    )
