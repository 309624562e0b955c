"""Beep and talk from a program of one's own: python examples/robot_sounds.py."""

from voz import BuiltinSound, SoundClient

with SoundClient() as client:  # at its end it waits for what is still heard
    client.play(BuiltinSound.BACKINGUP)
    client.say("I am going back")
