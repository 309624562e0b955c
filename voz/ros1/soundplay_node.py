"""The node `soundplay`: plays the requests of programs made for sound_play."""

from __future__ import annotations

import threading
from typing import Any, NoReturn

from voz.errors import VozError
from voz.ros1.messages import (
    ALL,
    ONCE,
    PLAY_FILE,
    SAY,
    START,
    STOP,
    TOPIC,
    sound_request,
)
from voz.ros1.node import Ros1Node, load_rospy, run_node, subscribe
from voz.speech.sound_client import SoundClient

END_CHECK_INTERVAL = 0.2
"""How often the end is looked for, s."""


def obey(client: SoundClient, request: Any) -> None:
    """Do what a SoundRequest asks for, without waiting for a sound to end; raises VozError."""
    sound, command, volume = request.sound, request.command, request.volume
    if command not in (STOP, ONCE, START):
        raise VozError(f"{command} is not a sound command; give 0, 1 or 2")
    if sound == SAY:
        voice = request.arg2.removeprefix("voice_")
        if command == STOP:
            client.stop_saying(request.arg)
        elif command == ONCE:
            client.say(request.arg, voice, volume)
        else:
            client.repeat(request.arg, volume, voice)
    elif sound == PLAY_FILE:
        if command == STOP:
            client.stop_wave(request.arg)
        else:
            play_file = client.play_wave if command == ONCE else client.start_wave
            play_file(request.arg, volume)
    elif command == STOP:
        client.stop(sound)
    elif sound == ALL:
        raise VozError("all sounds can only be stopped")
    else:
        play = client.play if command == ONCE else client.start
        play(sound, volume)


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
