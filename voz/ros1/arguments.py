"""The special arguments of a ROS 1 node, such as `__ns:=/r1`, with the meaning rospy gives them.

rospy looks for some of them in `sys.argv`, which a watchdog's process has not. So they become
environment variables: rospy, voz, and every process that this one starts, read those.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from voz.errors import ConfigError
from voz.ros1.master import WATCHDOG, check_namespace, is_address

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
    """Return the arguments of the watchdog of this process's node: no two nodes have one name.

    Its private parameters are left out: what they set is in the watchdog's settings.

    Args:
        node: its full name.
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
