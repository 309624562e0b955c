"""The typed tables of `voz.toml`; `voz/config.py` puts them together and reads the file."""

from __future__ import annotations

import re
from math import hypot
from typing import Annotated, Literal, NamedTuple

import msgspec

from voz.errors import ConfigError
from voz.records import CheckedRecord, Fraction

Search = Literal["grammar", "lm"]
Ask = Literal["never", "standing", "always"]
NotNegative = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
AtLeastOne = Annotated[float, msgspec.Meta(ge=1, le=1e6)]
NAME = re.compile(r"[^\W\d_](?:[^\W\d_]|'){0,39}( (?:[^\W\d_]|'){1,40}){0,4}")
Pause = Annotated[float, msgspec.Meta(ge=0.03, le=1)]
Alarms = Annotated[float, msgspec.Meta(gt=0, le=1e4)]
Gigabytes = Annotated[float, msgspec.Meta(ge=0.001, le=1e5)]
RosName = Annotated[str, msgspec.Meta(pattern=r"^[/~]?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z0-9_]+)*\Z")]
ROS_NAME = r"/?[a-zA-Z_][a-zA-Z0-9_]*(/[a-zA-Z_][a-zA-Z0-9_]*)*"
TopicName = Annotated[str, msgspec.Meta(pattern=rf"^{ROS_NAME}\Z")]
Namespace = Annotated[str, msgspec.Meta(pattern=rf"^({ROS_NAME})?\Z")]
Domain = Annotated[int, msgspec.Meta(ge=0, le=232)]
Meters = Annotated[float, msgspec.Meta(ge=0, le=100)]
Length = Annotated[float, msgspec.Meta(ge=0.1, le=100)]  # thinner, and a robot drives through it
Angle = Annotated[float, msgspec.Meta(ge=-6.3, le=6.3)]
Rate = Annotated[float, msgspec.Meta(ge=0.01, le=10)]
Seconds = Annotated[float, msgspec.Meta(ge=0.01, le=60)]


class Section(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """A table of voz.toml; unknown names are refused, so that a typing error is noticed."""


class Recognition(Section, frozen=True, kw_only=True):
    """How speech becomes text.

    Attributes:
        name: what the robot is called, such as "hey robot": then a spoken command counts if it is
            said within 8 s of the name, or right after it. One that stops always does.
        ask: whether the robot asks about a command of which it is nearly sure: "never", "standing"
            for what does not move it, or "always"; but never about what stops it.
        search: "grammar" hears whole commands only; "lm" is the trigram model of the original.
        false_alarms_per_hour: how many commands may be heard in an hour of people's talk near the
            robot; fewer cost more commands that have to be said again. None is 0.5, and 20 where
            there is no phoneme network.
        never_missed: commands that stop the robot, so that missing one is worse than obeying one
            that was not said. In doubt they are taken rather than another command.
        missed_cost: how many times worse it is. Odds that are lower by this factor are enough for
            these commands, which talk then triggers up to this many times as often.
        early_decision: a command is understood when its speaker pauses for so long, s; less is
            faster, and cuts slow speakers off.
        threshold: the confidence (0 to 1) that every command needs, in place of the three above.
        use_network: whether the phoneme network decides; False leaves it all to pocketsphinx.
        network: a file of weights for it, made by `training/teach.py`, from the folder you are in;
            None and "" take the one that comes with voz.
        confidence: a model of `voz fit-confidence`, from the folder you are in; None and "" take
            the one that comes with voz.
    """

    name: str = ""
    ask: Ask = "never"
    search: Search = "grammar"
    false_alarms_per_hour: Alarms | None = None
    never_missed: tuple[str, ...] = ("stop",)
    missed_cost: AtLeastOne = 2.0
    early_decision: Pause = 0.06
    threshold: Fraction | None = None
    use_network: bool = True
    network: str | None = None
    confidence: str | None = None

    def __post_init__(self) -> None:
        """Write the name as it is spoken; raises ConfigError for one that cannot be said."""
        super().__post_init__()
        said = " ".join(self.name.lower().split())
        if said and not NAME.fullmatch(said):
            raise ConfigError(f'`name` is "{self.name}"; write one to five words of letters')
        msgspec.structs.force_setattr(self, "name", said)

    @property
    def more_than_commands(self) -> bool:
        """Whether a name, or answers to what the robot asks, are understood too."""
        return bool(self.name) or self.ask != "never"


class SpokenLanguage(Section, frozen=True, kw_only=True):
    """What people speak; without any of this it is English.

    Attributes:
        name: one that espeak-ng speaks, such as "es", or of a copy that `voz language add` took.
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
        voice: one of `voz say --list-voices`, or of espeak-ng, as `espeak-ng:es`; that is the
            default in other languages than English.
        half_duplex: while the robot speaks, only the commands of `never_missed` are heard; False
            is for a headset, as `--no-half-duplex` is.
        barge_in: whether commands are obeyed while the robot speaks, which then falls silent; but
            not those that have a word in common with what it says.
    """

    enabled: bool = True
    voice: str = "kal_diphone"
    half_duplex: bool = True
    barge_in: bool = False


class Recording(Section, frozen=True, kw_only=True):
    """What `voz run --record` keeps.

    Attributes:
        gigabytes: what the recordings may take on the disk; beyond it the oldest are removed.
    """

    gigabytes: Gigabytes = 1.0


class Tabletop(NamedTuple):
    """A rectangle along the walls: its corner nearest to the origin and its sizes, m."""

    x: float
    y: float
    width: float
    depth: float

    def holds(self, x: float, y: float) -> bool:
        """Whether a point is on it."""
        return self.x <= x <= self.x + self.width and self.y <= y <= self.y + self.depth

    def gap(self, x: float, y: float, radius: float) -> float:
        """Distance from a circle to it, m; below 0 they overlap."""
        beside_x = max(self.x - x, 0.0, x - self.x - self.width)
        beside_y = max(self.y - y, 0.0, y - self.y - self.depth)
        return hypot(beside_x, beside_y) - radius


def gap_to_walls(x: float, y: float, radius: float, room: tuple[float, float]) -> float:
    """Distance from a circle to the nearest wall, m; below 0 it is in the wall."""
    return min(x, room[0] - x, y, room[1] - y) - radius


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
    start: tuple[Meters, Meters, Angle] = (0.7, 0.6, 0.0)
    table: tuple[Meters, Meters, Length, Length] = (1.5, 1.35, 0.9, 0.45)
    table_height: Meters = 0.7
    beer: tuple[Meters, Meters] = (1.7, 1.5)
    cocacola: tuple[Meters, Meters] = (2.2, 1.5)
    radius: Annotated[float, msgspec.Meta(ge=0.05, le=5)] = 0.17
    max_linear: Rate = 1.0
    max_angular: Rate = 2.0
    linear_acceleration: Rate = 0.5
    angular_acceleration: Rate = 2.0
    time_constant: Seconds = 0.15
    cmd_vel_timeout: Seconds = 0.5
    arm_speed: Rate = 2.5

    def __post_init__(self) -> None:
        """Raise ConfigError if the robot starts in a wall, or objects are not on the table."""
        super().__post_init__()
        table, (x, y, _) = Tabletop(*self.table), self.start
        if table.x + table.width > self.room[0] or table.y + table.depth > self.room[1]:
            raise ConfigError("the table is not within the room")
        for name, place in (("beer", self.beer), ("cocacola", self.cocacola)):
            if not table.holds(*place):
                raise ConfigError(f"the {name} is not on the table")
        if gap_to_walls(x, y, self.radius, self.room) < 0:
            raise ConfigError("at its start the robot is in a wall")
        if table.gap(x, y, self.radius) < 0:
            raise ConfigError("at its start the robot is in the table")


class Ros1(Section, frozen=True, kw_only=True):
    """Names in ROS 1; relative ones are below the namespace, `ROS_NAMESPACE`.

    Attributes:
        node: what voz is called.
        cmd_vel: the topic of the velocity.
        selected_object: the topic of what the arm points at.
        recognizer_output: the topic of the commands that were understood.
        awake: the topic of whether a robot with a name is awake.
        odom: the topic of the base's odometry: how far it came.
        cancel: the actions whose goals end wherever the robot is stopped: what drives beside voz.
    """

    node: RosName = "voz"
    cmd_vel: RosName = "cmd_vel"
    selected_object: RosName = "selected_object"
    recognizer_output: RosName = "recognizer/output"
    awake: RosName = "recognizer/awake"
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
        awake: topic of whether a robot with a name is awake.
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
    awake: TopicName = "recognizer/awake"
    odom: TopicName = "odom"
    diagnostics: TopicName = "/diagnostics"
    wait: NotNegative = 5.0
    cancel: tuple[TopicName, ...] = (
        "follow_waypoints",
        "navigate_through_poses",
        "navigate_to_pose",
    )
