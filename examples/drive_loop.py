"""Drive a robot in a loop of one's own: python examples/drive_loop.py FILE."""

import sys

import soundfile

import voz


def move(event: voz.Event) -> None:
    """Do what the controller asks for."""
    if isinstance(event, voz.Twist):
        print(f"{event.t:.1f} s: {event.linear:g} m/s, {event.angular:g} rad/s")


controller = voz.Controller([move], voz.Safety(), listening=True)
tenths = 0
try:
    with soundfile.SoundFile(sys.argv[1]) as recording:
        listener = voz.load().listen(recording.samplerate)
        blocks = recording.blocks(recording.samplerate // 10)
        for tenths, block in enumerate(blocks, start=1):  # 10 times a second
            for event in listener.feed(block):
                controller.hear(event)
            controller.send(tenths / 10)
except BrokenPipeError:  # as in `| head`: nobody reads any more what is printed
    sys.stdout = None
finally:  # whatever ends the loop, the robot stops
    controller.zero(tenths / 10)
