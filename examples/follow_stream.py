"""Understand a stream of one's own: arecord -f S16_LE -r 48000 | python follow_stream.py."""

import sys

import numpy

import voz

listener = voz.load().listen(rate=48000)
while block := sys.stdin.buffer.read(9600):  # 0.1 s
    for event in listener.feed(numpy.frombuffer(block, numpy.int16)):
        print(event, flush=True)
print(*listener.finish(), sep="\n")
