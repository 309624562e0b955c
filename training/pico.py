"""Speak what is on stdin by a voice of SVOX Pico, PyPI's `ttspico`: pico.py LANGUAGE OUT.wav."""

import sys

import numpy as np
import soundfile
import ttspico

RATE = 16_000

language, out = sys.argv[1:]
pcm = ttspico.TtsEngine(language).speak(sys.stdin.read())
soundfile.write(out, np.frombuffer(pcm, np.int16), RATE)
