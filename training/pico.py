"""Speak what is on stdin by a voice of SVOX Pico, PyPI's `py-nanotts`: pico.py LANGUAGE OUT.wav."""

import sys

import numpy as np
import soundfile
from py_nanotts import NanoTTS

RATE = 16_000

language, out = sys.argv[1:]
pcm = NanoTTS().speak(sys.stdin.read(), language)
soundfile.write(out, np.frombuffer(pcm, np.int16), RATE)
