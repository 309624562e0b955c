"""The node `soundplay`: plays the requests of programs made for sound_play."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, NoReturn

from voz.errors import AudioError, VozError
from voz.printable import shown_value
from voz.ros1.node import Ros1Node, load_rospy, run_node, subscribe
from voz.ros1.own_messages import (
    ALL,
    ONCE,
    PLAY_FILE,
    SAY,
    START,
    STOP,
    TOPIC,
    sound_request,
)
from voz.speech.sound_client import SoundClient
from voz.speech.synthesis import ESPEAK_PREFIX, is_espeak

PACKAGE_PREFIX = "package://"

END_CHECK_INTERVAL = 0.2
"""How often the end is looked for, s."""


def obey(client: SoundClient, request: Any) -> None:
    """Do what a SoundRequest asks for, without waiting for a sound to end; raises VozError."""
    sound, command, volume = request.sound, request.command, request.volume
    if command not in (STOP, ONCE, START):
        raise VozError(f"{command} is not a sound command; give 0, 1 or 2")
    if sound == SAY:
        voice = _voice(request.arg2)
        if command == STOP:
            client.stop_saying(request.arg)
        elif command == ONCE:
            client.say(request.arg, voice, volume)
        else:
            client.repeat(request.arg, volume, voice)
    elif sound == PLAY_FILE:
        path = _file(request.arg, request.arg2)
        if command == STOP:
            client.stop_wave(path)
        else:
            play_file = client.play_wave if command == ONCE else client.start_wave
            play_file(path, volume)
    elif command == STOP:
        client.stop(sound)
    elif sound == ALL:
        raise VozError("all sounds can only be stopped")
    else:
        play = client.play if command == ONCE else client.start
        play(sound, volume)


def _voice(name: str) -> str:
    """Read a voice of sound_play, as `voice_kal_diphone:ISO-8859-15`; texts are Unicode here."""
    voice = name.removeprefix("voice_")
    kind = ESPEAK_PREFIX if is_espeak(voice) else ""
    return kind + voice.removeprefix(kind).partition(":")[0]


def _file(name: str, package: str) -> str:
    """Return the path of a file: of a package, if one is named; raises AudioError."""
    if name.startswith(PACKAGE_PREFIX):
        package, _, name = name.removeprefix(PACKAGE_PREFIX).partition("/")
    if not package:
        return name
    import rospkg  # rospy needs it, too

    try:
        return str(Path(rospkg.RosPack().get_path(package), name))
    except rospkg.ResourceNotFound:
        raise AudioError(
            f"there is no package {shown_value(package)}", "source the workspace that has it"
        ) from None


def soundplay(node: Ros1Node) -> None:
    """Play requests on `robotsound` until the node is ended."""
    rospy = load_rospy()
    ended = threading.Event()
    client = SoundClient(warn=rospy.logwarn)

    def receive(request: Any) -> None:
        try:
            obey(client, request)
        except VozError as error:
            rospy.logwarn(str(error))

    try:
        subscribe(TOPIC, sound_request(), receive)
        while not node.over:
            ended.wait(END_CHECK_INTERVAL)
    finally:
        client.close()


def main() -> NoReturn:
    """Run the node."""
    run_node("soundplay", soundplay)


if __name__ == "__main__":
    main()
