"""A microphone to iterate over, one in the background, and streams for asyncio."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator

import numpy as np
import pytest
from recordings import GO_BACK, Recording

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError
from voz.events import Utterance

BACKGROUND = """
import sys, threading
import voz

wanted, heard, enough = int(sys.argv[1]), [], threading.Event()

def take(utterance):
    print(utterance, flush=True)
    heard.append(utterance)
    if len(heard) == wanted:
        enough.set()
    if sys.argv[2] == "exit":
        enough.set()
        sys.exit(3)
    if sys.argv[2] == "fail":
        enough.set()
        raise ValueError("not this one")

stop = voz.load().listen_in_background(take)
print("listening", flush=True)
enough.wait(60)
try:
    stop()
except (ValueError, SystemExit) as error:
    print("raised:", error)
print("threads:", threading.active_count())
"""

NO_MICROPHONE = """
import voz
for listen in (voz.load().microphone, lambda: voz.load().listen_in_background(print)):
    try:
        listen()
    except voz.AudioError as error:
        print(error)
"""


def test_a_file_is_decoded_by_its_name(recognizer: Recognizer, session: Recording) -> None:
    by_name = recognizer.decode(str(session.path))
    assert by_name == recognizer.decode(session.path)
    assert [str(heard) for heard in by_name if heard] == session.commands
    assert {heard.source for heard in by_name} == {str(session.path)}


def test_a_file_has_its_own_rate(recognizer: Recognizer, session: Recording) -> None:
    with pytest.raises(AudioError, match="a file has its own rate"):
        recognizer.decode(session.path, rate=16000)
    with pytest.raises(AudioError, match="there is no such file"):
        recognizer.decode("no_such_file.wav")


def in_blocks(samples: Samples) -> Iterator[Samples]:
    yield from np.array_split(samples, len(samples) // 1600)


async def in_blocks_async(samples: Samples) -> AsyncIterator[Samples]:
    for block in in_blocks(samples):
        await asyncio.sleep(0)
        yield block


@pytest.mark.parametrize("blocks", [in_blocks, in_blocks_async])
def test_a_stream_is_recognized_while_the_event_loop_goes_on(
    blocks: object, recognizer: Recognizer, session: Recording
) -> None:
    turns = 0

    async def listen() -> list[Utterance]:
        async def count() -> None:
            nonlocal turns
            while True:
                turns += 1
                await asyncio.sleep(0)

        counting = asyncio.create_task(count())
        stream = recognizer.astream(blocks(session.samples()), SAMPLE_RATE)  # type: ignore[operator]
        heard = [utterance async for utterance in stream]
        counting.cancel()
        return heard

    assert [str(heard) for heard in asyncio.run(listen()) if heard] == session.commands
    assert turns > len(session.commands)


def test_a_stream_without_rate_is_refused_at_once(recognizer: Recognizer) -> None:
    with pytest.raises(AudioError, match="rate"):
        recognizer.astream([np.zeros(1600, np.int16)])


@pytest.mark.slow
@pytest.mark.parametrize("how", ["well", "fail", "exit"])
def test_a_microphone_is_listened_to_in_the_background(how: str, pulse: dict[str, str]) -> None:
    command = [sys.executable, "-c", BACKGROUND, "2", how]
    with subprocess.Popen(command, env=pulse, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "listening\n"
        for _ in range(2 if how == "well" else 1):
            subprocess.run(["paplay", "--device=mic", str(GO_BACK)], env=pulse, check=True)
        output, _ = process.communicate(timeout=60)
    raised = {"fail": "raised: not this one", "exit": "raised: 3"}
    heard = ["go back", "go back"] if how == "well" else ["go back", raised[how]]
    assert output.splitlines() == [*heard, "threads: 1"]


def test_without_a_microphone_there_is_one_line(no_sound: dict[str, str]) -> None:
    command = [sys.executable, "-c", NO_MICROPHONE]
    done = subprocess.run(command, env=no_sound, capture_output=True, text=True, check=True)
    assert done.stdout == 2 * "there is no microphone; connect one and start again\n"
