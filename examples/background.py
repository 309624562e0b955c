"""Listen while the program does something else, until Enter: python examples/background.py."""

import voz


def note(heard: voz.Utterance) -> None:
    """Take what was said; this is called on another thread."""
    if heard:
        print(heard, flush=True)


stop = voz.load().listen_in_background(note)
input("listening\n")
stop()
