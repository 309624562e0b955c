"""This process as a ROS 1 node: its arguments, its start, its watch over the master, its end."""

from __future__ import annotations

import os
import re
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

from voz.config import Config, load_config, overridden
from voz.errors import ConfigError, RobotError, VozError
from voz.printable import printable
from voz.process import signals
from voz.process.setup import set_up
from voz.process.signals import WRONG_CALL
from voz.process.standard_streams import quiet_libraries, unblocked_output
from voz.ros1.master import WATCHDOG, ask, check_namespace, is_address, master_uri

VARIABLES: Mapping[str, str] = {
    "__ns": "ROS_NAMESPACE",
    "__master": "ROS_MASTER_URI",
    "__ip": "ROS_IP",
    "__hostname": "ROS_HOSTNAME",
}
"""What these arguments mean, as variables."""

ADDRESSES = ("__ip", "__hostname")
"""Two names of one thing to rospy: the first that is given counts, and empty it chooses one."""


def apply_special_arguments(arguments: Sequence[str]) -> None:
    """Put what the arguments say into the environment, before rospy is imported.

    rospy looks for some of them in `sys.argv`, which a watchdog's process has not. So they become
    environment variables: rospy, voz, and every process that this one starts, read those.

    Raises:
        ConfigError: an argument cannot be, and rospy would fail by it or wait forever.
    """
    given: dict[str, str] = {}
    for argument in arguments:
        name, _, value = argument.partition(":=")
        if ":=" in value:
            raise ConfigError(f"{argument}: `:=` stands there twice; write NAME:=VALUE")
        if name.strip() == "__name":
            _check_name(value.strip())
        elif name in VARIABLES:
            given.setdefault(name, value)  # the first one counts
    if "__ns" in given:
        check_namespace(given["__ns"], "__ns:=")
    if "__master" in given and not is_address(given["__master"]):
        said = given["__master"]
        raise ConfigError(
            f"__master:= is {said!r}: set it to an address like http://localhost:11311"
        )
    address = next((name for name in given if name in ADDRESSES), None)
    if address:
        for name in ADDRESSES:
            os.environ.pop(VARIABLES[name], None)
    for name, value in given.items():
        if name not in ADDRESSES or (name == address and value):
            os.environ[VARIABLES[name]] = value


def watchdog_arguments(node: str) -> tuple[str, ...]:
    """Return the arguments of the watchdog of a node, by its full name: no two nodes have one name.

    Its private parameters are left out: what they set is in the watchdog's settings.
    """
    from rospy.names import get_resolved_mappings

    namespace, _, name = node.rpartition("/")
    mappings = dict(get_resolved_mappings())
    if log := mappings.get("__log"):  # two processes cannot write one file
        mappings["__log"] = str(Path(log).with_stem(f"{Path(log).stem}{WATCHDOG}"))
    mappings |= {"__ns": namespace, "__name": f"{name}{WATCHDOG}"}
    return tuple(f"{name}:={value}" for name, value in mappings.items())


def _check_name(name: str) -> None:
    if name and not re.fullmatch(r"/?[A-Za-z]\w*(/\w+)*", name, re.ASCII):
        raise ConfigError(f"__name:= is {name!r}: set it to a name like control_voz")


MASTER_CHECK_INTERVAL = 0.1
"""Time between two calls of the master, s; without it the robot stops in less than 0.5 s."""

SENDING_TIME = 0.2
"""Time for the last messages to leave, s: rospy sends them on threads that cannot be joined."""


class Ros1Node:
    """A ROS node for the length of a `with` block, one for each process."""

    def __init__(self, name: str, arguments: Sequence[str] = ()) -> None:
        """Join ROS.

        Args:
            name: of the node, unless the arguments give another.
            arguments: those of the process: remappings, private parameters and special ones.

        Raises:
            RobotError: there is no rospy or no master.
            ConfigError: an argument or the namespace is invalid.
        """
        apply_special_arguments(arguments)
        check_namespace()
        rospy = load_rospy()
        try:
            ask("getPid", "/voz")
        except OSError as error:
            raise RobotError(
                f"there is no ROS master at {master_uri()} ({error.strerror or error})",
                "start `roscore`, or set ROS_MASTER_URI",
            ) from error
        try:
            # Signals are ours: they end the run by a message, and that stops the robot.
            rospy.init_node(name, argv=["voz", *arguments], disable_signals=True)
        except (rospy.ROSException, ValueError, OSError) as error:
            reason = " ".join(str(error).split())
            raise RobotError(f"the ROS node {name} cannot be started ({reason})") from error
        self.name: str = rospy.get_name()  # its full name, with its namespace
        self._rospy = rospy
        self._problem: str | None = None
        self._ended = threading.Event()
        self._watch = threading.Thread(
            target=self._watch_master, name="voz-ros-master", daemon=True
        )
        self._watch.start()

    def __enter__(self) -> Ros1Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def over(self) -> bool:
        """Whether somebody ended the node, as by `rosnode kill`."""
        return bool(self._rospy.is_shutdown())

    def trouble(self) -> str | None:
        """Return why ROS cannot be reached now; None if all is well."""
        return "the ROS node was ended" if self.over else self._problem

    def on_shutdown(self, act: Callable[[], None]) -> None:
        """Call `act` when somebody ends the node, while messages can still be sent."""

        def last() -> None:
            act()
            self._ended.wait(SENDING_TIME)

        self._rospy.on_shutdown(last)

    def each_second(self, name: str, act: Callable[[], None]) -> None:
        """Call `act` once a second on a thread of that name; it may wait, and raise OSError."""

        def go_on() -> None:
            while not self._ended.wait(1.0) and not self.over:
                with suppress(OSError):
                    act()

        threading.Thread(target=go_on, name=name, daemon=True).start()

    def close(self) -> None:
        """Leave ROS after the last messages were sent."""
        self._ended.wait(SENDING_TIME)
        self._ended.set()
        self._rospy.signal_shutdown("voz ends")

    def _watch_master(self) -> None:
        """Ask the master again and again; if that ends by a mistake, ROS counts as lost."""
        try:
            while not self._ended.wait(MASTER_CHECK_INTERVAL) and not self.over:
                self._look()
        except BaseException as error:
            self._problem = f"the ROS master is no longer watched ({error!r})"

    def _look(self) -> None:
        """Ask the master once; register again with a new one."""
        try:
            known = ask("lookupNode", self.name, self.name)
            if known is None and not self.over:
                _register_again()
        except OSError:
            self._problem = f"the ROS master at {master_uri()} does not answer"
        else:
            self._problem = None


def load_rospy() -> Any:
    """Import rospy; raises RobotError if it is not there."""
    try:
        import rospy
    except ImportError as error:
        raise RobotError(
            f"ROS 1 is not there for {sys.executable} ({error})",
            "`make ros1` in a clone installs it, for the voz in .venv-ros1/bin",
        ) from error
    return rospy


def subscribe(topic: str, kind: Any, act: Callable[[Any], None], **how: Any) -> Any:
    """Subscribe to a topic; what cannot be read is dropped.

    rospy would drop the connection with it, and stumble over the same bytes whenever it connects
    again. `act` is called with each message on a thread of rospy's; `how` is what else
    `rospy.Subscriber` takes.
    """

    class Received(kind):  # type: ignore[misc]
        is_readable = True

        def deserialize(self, data: bytes) -> Any:
            try:
                return super().deserialize(data)
            except Exception:  # too short, or a length that cannot be
                self.is_readable = False
                return self

    def take(message: Any) -> None:
        if message.is_readable:
            act(message)

    return load_rospy().Subscriber(topic, Received, take, **how)


def _register_again() -> None:
    """Register all topics and services with a new master; rospy does so only once."""
    from rospy.impl import registration
    from rospy.topics import get_topic_manager

    topics, kinds = get_topic_manager(), registration.Registration
    listeners = registration.get_registration_listeners()
    for kind, entries in (
        (kinds.PUB, topics.get_publications()),
        (kinds.SUB, topics.get_subscriptions()),
        (kinds.SRV, registration.get_service_manager().get_services()),
    ):
        for name, what in entries:
            listeners.notify_added(name, what, kind)


def run_node(name: str, work: Callable[[Ros1Node], None]) -> NoReturn:
    """Run `work` as a node until a signal or `rosnode kill` ends it: both are a good end."""
    signals.install(shell_exit_code=False)
    set_up()
    code = 1
    try:
        with quiet_libraries(), unblocked_output(), Ros1Node(name, sys.argv[1:]) as node:
            work(node)
        code = 0
    except VozError as error:
        print(printable(f"{name}: {error}"), file=sys.stderr)
        code = WRONG_CALL
    except BaseException:
        # A signal raises while the node starts; cut short by it, an import may raise anything.
        by_signal = signals.exit_code()
        if by_signal is None:
            raise
        code = by_signal
    finally:
        signals.restore_default_handlers()
        if signals.is_audio_thread_left():
            signals.force_exit(code)
    sys.exit(code)


TRUE_WORDS, FALSE_WORDS = ("true", "1", "yes"), ("false", "0", "no")


def text_parameter(name: str) -> str | None:
    """Read a parameter as text; None if it is not set, or empty. Raises RobotError."""
    try:
        value = load_rospy().get_param(f"~{name}", "")
    except OSError as error:
        raise RobotError(f"the ROS master does not answer ({error}); is it running?") from error
    return str(value).strip() or None


def number_parameter(name: str) -> float | None:
    """Read a parameter that is a number; raises ConfigError if it is none."""
    value = text_parameter(name)
    try:
        return None if value is None else float(value)
    except ValueError:
        raise ConfigError(f"~{name}: {value} is not a number; correct the parameter") from None


def switch_parameter(name: str) -> bool | None:
    """Read a parameter that is true or false; raises ConfigError if it is neither."""
    value = text_parameter(name)
    if value is None or value.lower() in TRUE_WORDS + FALSE_WORDS:
        return None if value is None else value.lower() in TRUE_WORDS
    raise ConfigError(f"~{name}: {value} is neither true nor false; correct the parameter")


def choice_parameter(name: str, among: tuple[str, ...]) -> str:
    """Read a parameter that is one of some words; the first if it is not set."""
    value = text_parameter(name) or among[0]
    if value not in among:
        raise ConfigError(f"~{name}: {value} is none of {', '.join(among)}; correct the parameter")
    return value


def read_settings(**speech: Any) -> Config:
    """Read `~config`, a voz.toml, and put the parameters that have its names in their place.

    `speech` are settings of how the robot answers.

    Raises:
        ConfigError: a value cannot be.
        RobotError: the master does not answer.
    """
    file = text_parameter("config")
    return overridden(
        load_config(Path(file)) if file else Config(),
        {
            "recognition": {
                "search": text_parameter("search"),
                "threshold": number_parameter("threshold"),
            },
            "safety": {"enabled": switch_parameter("safety")},
            "speech": {"voice": text_parameter("voice"), **speech},
        },
        "a parameter of the node",
        "correct it",
    )
