"""Understand a recording that is an array: python examples/decode_array.py FILE."""

import signal
import sys

import soundfile

import voz

signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # end without a word, as in `| head`
array, rate = soundfile.read(sys.argv[1])  # floats or int16, any rate, one channel or several
recognizer = voz.load()
for utterance in recognizer.decode(array, rate):
    print(f"{utterance.start:.2f} s", utterance.text, utterance.confidence, utterance.accepted)
