"""Print what is said into the microphone, until Ctrl-C: python examples/microphone.py."""

import contextlib

import voz

with voz.load().microphone() as utterances, contextlib.suppress(KeyboardInterrupt):
    print("listening", flush=True)
    for heard in utterances:
        print(heard if heard else f"not sure enough: {heard}", flush=True)
