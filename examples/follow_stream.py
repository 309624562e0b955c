"""Understand a stream of one's own: arecord -f S16_LE -r 48000 | python follow_stream.py."""

import signal
import sys

import numpy

import voz

for number in (signal.SIGINT, signal.SIGPIPE):  # end without a word by Ctrl-C, or as in `| head`
    signal.signal(number, signal.SIG_DFL)
listener = voz.load().listen(rate=48000)
while block := sys.stdin.buffer.read(9600):  # 0.1 s
    for event in listener.feed(numpy.frombuffer(block, numpy.int16, len(block) // 2)):
        print(repr(event), flush=True)
for event in listener.finish():
    print(repr(event))
