"""Print what is said into the microphone: voz."""

import voz

for heard in voz.load().microphone():
    print(heard)
