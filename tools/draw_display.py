"""Draw docs/live.svg: what a terminal shows while `voz run` listens, here to a recording.

Run `python tools/draw_display.py`.
"""

from __future__ import annotations

from io import StringIO
from pathlib import Path
from types import SimpleNamespace

from rich.console import Console

import voz
from voz.api.recognizer import Recognizer
from voz.audio.sound_files import read_blocks
from voz.events import shift_time
from voz.language.language_files import find_language
from voz.settings import Recognition
from voz.terminal.display import Display

ROOT = Path(__file__).parent.parent
RECORDINGS = (
    "commands/festival_slt__start_speech.flac",
    "commands/festival_slt__go_forward.flac",
    "near_misses/festival_slt__turn_around.flac",
    "commands/festival_slt__turn_left.flac",
    "near_misses/festival_slt__point.flac",
    "commands/festival_slt__speed_up.flac",
)


def main() -> None:
    """Let the display hear some recordings, and keep how it looks then."""
    recognizer = Recognizer(find_language(None), Recognition())
    terminal = Console(record=True, width=78, force_terminal=True, file=StringIO())
    sound = SimpleNamespace(peak=0.12, background=-64.0, speaking=False, device="USB Audio Device")
    controller = voz.Controller([])
    display = Display(sound, controller, lambda: "")
    controller.receivers.append(display.receive)
    now = 0.0
    for name in RECORDINGS:
        blocks = list(read_blocks(ROOT / "audio_fixtures" / name))
        for event in recognizer.events(blocks, "microphone"):
            controller.hear(shift_time(event, now))
            controller.send(now + event.t)
        now += sum(map(len, blocks)) / 16000
    terminal.print(display)
    terminal.save_svg(str(ROOT / "docs" / "live.svg"), title="voz run")


if __name__ == "__main__":
    main()
