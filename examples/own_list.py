"""Understand a recording by a list of one's own: python examples/own_list.py FILE."""

import sys

import voz

recognizer = voz.load(
    [
        "go forward",
        "stop",
        "turn [the] {color} light on",  # the words in brackets may be left out
        "color = red | green",
    ]
)  # or a file with such lines; or nothing, for the commands that come with voz
for heard in recognizer.decode(sys.argv[1]):
    print(heard if heard else "not a command", dict(heard.slots))
