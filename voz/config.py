"""One typed configuration, read from `voz.toml`; what the file leaves out keeps its default."""

from __future__ import annotations

import re
import sys
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec.structs import replace

from voz.control.steps import CommandDefinition
from voz.control.table import CommandTable, command_table
from voz.errors import ConfigError
from voz.files import FEW_BYTES, read_text
from voz.simulation.room import Tabletop, gap_to_table, gap_to_walls

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Search = Literal["grammar", "lm"]
Fraction = Annotated[float, msgspec.Meta(ge=0, le=1)]
NotNegative = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
AtLeastOne = Annotated[float, msgspec.Meta(ge=1, le=1e6)]
Pause = Annotated[float, msgspec.Meta(ge=0.03, le=1)]
Alarms = Annotated[float, msgspec.Meta(gt=0, le=1e4)]
Metres = Annotated[float, msgspec.Meta(ge=0, le=100)]
Length = Annotated[float, msgspec.Meta(ge=0.1, le=100)]  # thinner, and a robot drives through it
Angle = Annotated[float, msgspec.Meta(ge=-6.3, le=6.3)]
Rate = Annotated[float, msgspec.Meta(ge=0.01, le=10)]
Gigabytes = Annotated[float, msgspec.Meta(ge=0.001, le=1e5)]
RosName = Annotated[str, msgspec.Meta(pattern=r"^[/~]?[A-Za-z]\w*(/\w+)*$")]
Seconds = Annotated[float, msgspec.Meta(ge=0.01, le=60)]
ROS_NAME = r"/?[a-zA-Z_][a-zA-Z0-9_]*(/[a-zA-Z_][a-zA-Z0-9_]*)*"
TopicName = Annotated[str, msgspec.Meta(pattern=rf"^{ROS_NAME}\Z")]
Namespace = Annotated[str, msgspec.Meta(pattern=rf"^({ROS_NAME})?\Z")]
Domain = Annotated[int, msgspec.Meta(ge=0, le=232)]


class Section(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A table of voz.toml: unknown names are refused, so that a typing error is not ignored."""


class Recognition(Section, frozen=True, kw_only=True):
    """How speech becomes text.

    Attributes:
        search: "grammar" hears whole commands only; "lm" is the trigram model of the original.
        false_alarms_per_hour: how many commands may be heard in an hour of people's talk near the
            robot; fewer cost more commands that have to be said again. None is 0.5, and 20 where
            there is no second ear.
        never_missed: commands that stop the robot, so that missing one is worse than obeying one
            that was not said. In doubt they are taken rather than another command.
        missed_cost: how many times worse it is; by so much lower odds are enough for them, and as
            many times more often, at most, are they heard in talk.
        early_decision: a command is understood when its speaker pauses for so long, s; less is
            faster, and cuts slow speakers off.
        threshold: the confidence (0 to 1) that every command needs, in place of the three above.
        second_ear: whether a network that hears phonemes has a say too; False leaves it all to
            pocketsphinx.
        confidence: a model of `voz fit-confidence`, from the folder you are in; None and "" take
            the one that comes with voz.
    """

    search: Search = "grammar"
    false_alarms_per_hour: Alarms | None = None
    never_missed: tuple[str, ...] = ("stop",)
    missed_cost: AtLeastOne = 2.0
    early_decision: Pause = 0.06
    threshold: Fraction | None = None
    second_ear: bool = True
    confidence: str | None = None


class SpokenLanguage(Section, frozen=True, kw_only=True):
    """What people speak; without any of this it is English.

    Attributes:
        name: what it is called; a copy that `voz language add` took has this name.
        acoustic_model: a folder in CMUSphinx's format, in place of the copy's.
        dictionary: a dictionary in CMUSphinx's format, in place of the copy's.
        pronunciations: rules for words that it lacks: letters, a tab and their phones a line.
    """

    name: str = "English"
    acoustic_model: str | None = None
    dictionary: str | None = None
    pronunciations: str | None = None


class Safety(Section, frozen=True, kw_only=True):
    """What stands between the command rules and a robot that runs away.

    Attributes:
        enabled: False gives the bare command rules, as `--no-safety` does.
        max_linear: limit of the forward and backward velocity, m/s (S4).
        max_angular: limit of the turning velocity, rad/s (S4).
        motion_time_limit: stop when no command was heard for so long, s; 0 is never (S6).
    """

    enabled: bool = True
    max_linear: NotNegative = 0.5
    max_angular: NotNegative = 1.0
    motion_time_limit: NotNegative = 0.0


class Speech(Section, frozen=True, kw_only=True):
    """How the robot answers.

    Attributes:
        enabled: False keeps it silent, as `--no-sound` does.
        voice: one of `voz say --list-voices`, or of espeak-ng, as `espeak-ng:es`.
        half_duplex: while the robot speaks, only the commands of `never_missed` are heard; False
            is for a headset, as `--no-half-duplex` is.
    """

    enabled: bool = True
    voice: str = "kal_diphone"
    half_duplex: bool = True


class Recording(Section, frozen=True, kw_only=True):
    """What `voz run --record` keeps.

    Attributes:
        gigabytes: what the recordings may take on the disk; beyond it the oldest are removed.
    """

    gigabytes: Gigabytes = 1.0


class Simulator(Section, frozen=True, kw_only=True):
    """The simulated robot and its room, whose corner is the origin.

    Attributes:
        room: its length along x and along y, m.
        start: where the robot is at first, x and y in m and its heading in rad.
        table: x and y of its corner nearest to the origin, its size along x and along y, m.
        table_height: of its top, m.
        beer: where on the table it stands, x and y, m.
        cocacola: the same.
        radius: of the robot, m.
        max_linear: limit of its own on the velocity, m/s.
        max_angular: the same, rad/s.
        linear_acceleration: how fast the velocity changes at most, m/s².
        angular_acceleration: the same, rad/s².
        time_constant: how long the velocity lags behind the one asked for, s.
        cmd_vel_timeout: it stops when no velocity came for so long, s.
        arm_speed: how fast a joint of the arm turns, rad/s.
    """

    room: tuple[Length, Length] = (2.6, 1.8)
    start: tuple[Metres, Metres, Angle] = (0.7, 0.6, 0.0)
    table: tuple[Metres, Metres, Length, Length] = (1.5, 1.35, 0.9, 0.45)
    table_height: Metres = 0.7
    beer: tuple[Metres, Metres] = (1.7, 1.5)
    cocacola: tuple[Metres, Metres] = (2.2, 1.5)
    radius: Annotated[float, msgspec.Meta(ge=0.05, le=5)] = 0.17
    max_linear: Rate = 1.0
    max_angular: Rate = 2.0
    linear_acceleration: Rate = 0.5
    angular_acceleration: Rate = 2.0
    time_constant: Seconds = 0.15
    cmd_vel_timeout: Seconds = 0.5
    arm_speed: Rate = 2.5

    def __post_init__(self) -> None:
        """Refuse a room in which the robot has no place, or the objects are not on the table.

        Raises:
            ValueError: so it is; msgspec makes its own error of it, which names the place.
        """
        table, (x, y, _) = Tabletop(*self.table), self.start
        if table.x + table.width > self.room[0] or table.y + table.depth > self.room[1]:
            raise ValueError("the table is not within the room")
        for name, place in (("beer", self.beer), ("cocacola", self.cocacola)):
            if not table.holds(*place):
                raise ValueError(f"the {name} is not on the table")
        if gap_to_walls(x, y, self.radius, self.room) < 0:
            raise ValueError("at its start the robot is in a wall")
        if gap_to_table(x, y, self.radius, table) < 0:
            raise ValueError("at its start the robot is in the table")


class Ros1(Section, frozen=True, kw_only=True):
    """Names in ROS 1; relative ones are below the namespace, `ROS_NAMESPACE`.

    Attributes:
        node: what voz is called.
        cmd_vel: the topic of the velocity.
        selected_object: the topic of what the arm points at.
        recognizer_output: the topic of the commands that were understood.
        odom: the topic of the base's odometry: how far it came.
        cancel: the actions whose goals end wherever the robot is stopped: what drives beside voz.
    """

    node: RosName = "voz"
    cmd_vel: RosName = "cmd_vel"
    selected_object: RosName = "selected_object"
    recognizer_output: RosName = "recognizer/output"
    odom: RosName = "odom"
    cancel: tuple[RosName, ...] = ("move_base",)


class Ros2(Section, frozen=True, kw_only=True):
    """The robot on ROS 2. A topic that begins with / is outside the namespace.

    Attributes:
        domain: only programs in the same one find each other; None asks `ROS_DOMAIN_ID`.
        namespace: goes before the topics, so that several robots have each their own.
        cmd_vel: topic of the velocities.
        stamped: whether they are sent as TwistStamped, as newer bases want, or as Twist.
        frame_id: the coordinate frame of the base, in a TwistStamped and a simulated `/tf`.
        selected_object: topic of the objects for the arm.
        output: topic of the commands that were heard.
        odom: topic of the base's odometry: how far it came.
        diagnostics: topic of what `rqt_robot_monitor` shows.
        wait: how long the start waits for somebody to listen, s.
        cancel: the actions whose goals end wherever the robot is stopped: what drives beside voz.
            One that starts others comes first, or it starts the next.
    """

    domain: Domain | None = None
    namespace: Namespace = ""
    cmd_vel: TopicName = "cmd_vel"
    stamped: bool = False
    frame_id: str = "base_link"
    selected_object: TopicName = "selected_object"
    output: TopicName = "recognizer/output"
    odom: TopicName = "odom"
    diagnostics: TopicName = "/diagnostics"
    wait: NotNegative = 5.0
    cancel: tuple[TopicName, ...] = (
        "follow_waypoints",
        "navigate_through_poses",
        "navigate_to_pose",
    )


class Config(Section, frozen=True, kw_only=True):
    """All settings.

    Attributes:
        lm: folder of the language files; None looks for `lm/` here, then in the package.
        robot: who receives the motion, by the names in `voz.robot.kinds`.
        own: settings of the user's own robots, by their modules: the arguments of their classes.
        commands: what each command does, beside or in place of what voz's own commands do.
        states: other sets of commands, by the name that the step `state` switches to.
    """

    lm: str | None = None
    robot: tuple[str, ...] = ("console",)
    language: SpokenLanguage = SpokenLanguage()
    recognition: Recognition = Recognition()
    safety: Safety = Safety()
    speech: Speech = Speech()
    recording: Recording = Recording()
    simulator: Simulator = Simulator()
    ros1: Ros1 = Ros1()
    ros2: Ros2 = Ros2()
    own: dict[str, dict[str, Any]] = {}
    commands: dict[str, CommandDefinition] = {}
    states: dict[str, dict[str, CommandDefinition]] = {}

    @property
    def table(self) -> CommandTable:
        """What each command does, with those that voz brings.

        Raises:
            ConfigError: with it the robot might not stop, or it contradicts itself.
        """
        return command_table({**_brought(), **self.commands}, self.states)


USUAL_COMMANDS = Path(__file__).parent / "control" / "commands.toml"
"""What the commands do that voz brings, as a user would write it."""


@cache
def usual_commands() -> CommandTable:
    """What the commands do that voz brings."""
    return Config().table


@cache
def _brought() -> dict[str, CommandDefinition]:
    return load_config(USUAL_COMMANDS).commands


def never_missing_a_stop(config: Config) -> Config:
    """Let the commands that stop the robot be among those that are not missed.

    Raises:
        ConfigError: the table of commands cannot be used.
    """
    names = dict.fromkeys([*config.recognition.never_missed, *sorted(config.table.stops)])
    return replace(config, recognition=replace(config.recognition, never_missed=tuple(names)))


def load_config(path: Path) -> Config:
    """Read a configuration file.

    Args:
        path: a TOML file with the tables and names of `Config`.

    Returns:
        The configuration; what the file does not name has its default.

    Raises:
        ConfigError: the file cannot be read, is no TOML, or holds a wrong name or value.
    """
    text = read_text(path, ConfigError, "give an existing file, saved as UTF-8", FEW_BYTES)
    try:
        settings = tomllib.loads(text)
        _check_commands(settings, text, path)
        return msgspec.convert(settings, Config)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    except RecursionError:
        raise ConfigError(f"{path}: has too many tables in each other; remove some") from None
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {error}; docs/settings.md lists the settings") from error
    except (ValueError, OverflowError):  # a number of more than 4300 digits
        raise ConfigError(f"{path}: has a number that is too long; shorten it") from None


def _check_commands(settings: dict[str, Any], text: str, path: Path) -> None:
    """Refuse a command that is wrong in itself; msgspec would leave out its name and line."""
    states = settings.get("states", {})
    tables = {"commands": settings.get("commands", {})}
    if isinstance(states, dict):
        tables |= {f"states.{name}": table for name, table in states.items()}
    for table, commands in tables.items():
        for name, command in commands.items() if isinstance(commands, dict) else ():
            try:
                msgspec.convert(command, CommandDefinition)
            except msgspec.ValidationError as error:
                why = str(error).partition(" - at `$`")[0]
                where = f"{path}{_line_of(name, text)}"
                raise ConfigError(f'{where}: [{table}] "{name}": {why}') from error


def _line_of(name: str, text: str) -> str:
    """Find where a command stands; empty if it is written in an unusual way."""
    quoted = rf"""["']?{re.escape(name)}["']?"""
    found = re.search(rf"^\s*({quoted}\s*[.=]|\[+[^\n]*{quoted}\s*\])", text, re.MULTILINE)
    return f":{text.count(chr(10), 0, found.end()) + 1}" if found else ""


def overridden(config: Config, options: dict[str, Any]) -> Config:
    """Put what was said on the command line in place of what the configuration has.

    Args:
        config: what holds otherwise.
        options: settings, and tables of settings, by their names; None changes nothing.

    Raises:
        ConfigError: a value cannot be.
    """
    settings = msgspec.to_builtins(config)
    for name, value in options.items():
        if isinstance(value, dict):
            settings[name].update({key: v for key, v in value.items() if v is not None})
        elif value is not None:
            settings[name] = value
    try:
        return never_missing_a_stop(msgspec.convert(settings, Config))
    except msgspec.ValidationError as error:
        raise ConfigError(f"an option cannot be used: {error}; see --help") from error
