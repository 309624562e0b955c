"""Drive a robot that runs `voz run --web`, from elsewhere: python examples/client.py LINK."""

import sys
import time

import voz

with voz.Client(sys.argv[1]) as robot:  # when this program ends, however, the robot stops
    for text in ("start speech", "go forward"):
        heard = robot.command(text)
        print(heard, "is obeyed" if heard.obeyed else f"is not obeyed: {heard.ignored}", flush=True)
    time.sleep(1)
    robot.command("stop")
