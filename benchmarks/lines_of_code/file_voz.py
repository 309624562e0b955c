"""Print what is said in a recording: voz."""

import voz

for heard in voz.load().decode("take.wav"):
    print(heard)
