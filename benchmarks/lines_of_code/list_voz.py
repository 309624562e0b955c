"""Print which of three commands is said into the microphone: voz."""

import voz

for heard in voz.load(["go forward", "turn left", "stop"]).microphone():
    if heard:
        print(heard)
