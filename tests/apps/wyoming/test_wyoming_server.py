"""`voz serve`, asked by the client of the Wyoming project itself."""

from __future__ import annotations

import asyncio
import json
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soxr
from calls import VOZ, in_process
from operator_page import with_noise
from programs import PATIENCE, free_port
from recordings import FIXTURES, ROOT
from spanish import RULES, spanish
from wyoming.asr import Transcribe, Transcript
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.client import AsyncClient
from wyoming.error import Error
from wyoming.event import Event
from wyoming.info import Describe, Info

from voz.audio.sound_files import read_samples
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.spoken_language import find_sources, read_language
from voz.settings import SpokenLanguage

pytestmark = pytest.mark.slow

RATE = 16_000


@contextmanager
def serving(*options: object, cwd: Path | None = None) -> Iterator[str]:
    """A server for the length of a `with` block; yields where it is asked."""
    uri = f"tcp://127.0.0.1:{free_port()}"
    command = [*VOZ, "serve", "--wyoming", uri, *map(str, options)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=cwd) as server:
        assert server.stderr
        assert server.stderr.readline() == f"serving at {uri}\n"
        yield uri
        server.terminate()
        assert server.wait(PATIENCE) in (0, -15, 143)
        assert "Traceback" not in server.stderr.read()


@pytest.fixture(scope="module")
def uri() -> Iterator[str]:
    with serving() as uri:
        yield uri


def clip(name: str) -> np.ndarray:
    return read_samples(FIXTURES / name)


async def ask(uri: str, *events: Event) -> Event | None:
    async with AsyncClient.from_uri(uri) as client:
        for event in events:
            await client.write_event(event)
        return await asyncio.wait_for(client.read_event(), PATIENCE)


def spoken(sound: np.ndarray, channels: int = 1, rate: int = RATE) -> list[Event]:
    """A request with sound in chunks of 0.1 s."""
    frames = np.repeat(sound[:, None], channels, axis=1)
    chunks = [frames[at : at + rate // 10] for at in range(0, len(frames), rate // 10)]
    return [
        Transcribe(language="en").event(),
        AudioStart(rate, 2, channels).event(),
        *(AudioChunk(rate, 2, channels, chunk.tobytes()).event() for chunk in chunks),
        AudioStop().event(),
    ]


def transcribed(uri: str, *events: Event) -> str:
    answer = asyncio.run(ask(uri, *events))
    assert answer
    return Transcript.from_event(answer).text


def test_it_tells_what_it_is(uri: str) -> None:
    answer = asyncio.run(ask(uri, Describe().event()))
    assert answer
    (program,) = Info.from_event(answer).asr
    assert (program.name, program.models[0].languages) == ("voz", ["en"])
    assert "go forward" in (program.models[0].description or "")


@pytest.mark.parametrize("channels", [1, 2])
def test_a_command_is_transcribed(uri: str, channels: int) -> None:
    sound = clip("commands/festival_slt__go_back.flac")
    assert transcribed(uri, *spoken(sound, channels)) == "go back"


def test_what_is_no_command_is_an_empty_text(uri: str) -> None:
    assert transcribed(uri, *spoken(clip("near_misses/festival_slt__turn_around.flac"))) == ""
    assert transcribed(uri, AudioStop().event()) == ""


def test_two_at_a_time_get_each_their_own(uri: str) -> None:
    async def both() -> list[Event | None]:
        names = ("go_back", "turn_left")
        clips = [clip(f"commands/festival_slt__{name}.flac") for name in names]
        return await asyncio.gather(*(ask(uri, *spoken(sound)) for sound in clips))

    texts = [Transcript.from_event(event).text for event in asyncio.run(both()) if event]
    assert texts == ["go back", "turn left"]


def in_a_room(name: str) -> list[Event]:
    """A request that goes on after the command, and does not say where that ends."""
    *events, _ = spoken(with_noise(FIXTURES / name, 0.3, 2.0))
    return events


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("commands/festival_slt__go_back.flac", "go back"),
        ("near_misses/festival_slt__turn_around.flac", ""),
    ],
)
def test_the_answer_comes_when_the_speech_ends_and_waits_for_no_audio_stop(
    uri: str, name: str, text: str
) -> None:
    assert transcribed(uri, *in_a_room(name)) == text


def test_what_follows_the_end_of_the_speech_belongs_to_no_request(uri: str) -> None:
    async def two_commands() -> list[Event | None]:
        async with AsyncClient.from_uri(uri) as client:
            for name in ("go_back", "turn_left"):
                for event in in_a_room(f"commands/festival_slt__{name}.flac"):
                    await client.write_event(event)
                await client.write_event(AudioChunk(RATE, 2, 1, bytes(RATE)).event())
                await client.write_event(AudioStop().event())
            await client.write_event(Describe().event())
            return [await asyncio.wait_for(client.read_event(), PATIENCE) for _ in range(3)]

    *answers, last = asyncio.run(two_commands())
    texts = [Transcript.from_event(event).text for event in answers if event]
    assert texts == ["go back", "turn left"]
    assert last
    assert Info.is_type(last.type)


def test_its_language_is_that_of_the_list(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "examples" / "spanish", tmp_path, dirs_exist_ok=True)
    spanish(tmp_path / "es")
    sources = find_sources(
        SpokenLanguage(
            name="es",
            acoustic_model=str(tmp_path / "es/model_parameters/es"),
            dictionary=str(tmp_path / "es/es.dic"),
            pronunciations=str(RULES),
        )
    )
    assert sources
    (tmp_path / "voz.toml").unlink()
    commands = tmp_path / "comandos.txt"
    build(commands, tmp_path / "lm", read_list(commands, read_language(sources)))
    with serving(cwd=tmp_path) as uri:
        told = asyncio.run(ask(uri, Describe().event()))
        answer = asyncio.run(ask(uri, AudioStop().event()))
    assert told
    assert Info.from_event(told).asr[0].models[0].languages == ["es"]
    assert answer
    assert Transcript.from_event(answer).language == "es"


@pytest.mark.parametrize(
    ("chunk", "complaint"),
    [
        (AudioChunk(RATE, 5, 1, bytes(400)), "8 to 32 bits"),
        (AudioChunk(RATE, 2, 65, bytes(1300)), "1 to 64 channels"),
        (AudioChunk(RATE, 2, 0, bytes(400)), "channels"),
        (AudioChunk(RATE, 2, 1, bytes(401)), "one format"),
        (AudioChunk(5, 2, 1, bytes(400)), "Hz"),
    ],
)
def test_sound_that_it_cannot_hear_is_one_line(uri: str, chunk: AudioChunk, complaint: str) -> None:
    answer = asyncio.run(ask(uri, chunk.event()))
    assert answer
    assert complaint in Error.from_event(answer).text


@pytest.mark.parametrize(("width", "dtype"), [(1, np.int8), (1, np.uint8), (3, None), (4, "<i4")])
@pytest.mark.parametrize(("rate", "channels"), [(RATE, 1), (48_000, 10)])
def test_sound_of_any_width_rate_and_channels_is_converted(
    uri: str, width: int, dtype: Any, rate: int, channels: int
) -> None:
    sound = soxr.resample(clip("commands/festival_slt__go_back.flac"), RATE, rate)
    wide = sound.astype(np.int64) << 16
    if dtype is None:
        data = (wide >> 8).astype("<i4").view(np.uint8).reshape(-1, 4)[:, :3]
    else:
        data = (wide >> 8 * (4 - width)) + (128 if dtype is np.uint8 else 0)
        data = data.astype(dtype).view(np.uint8).reshape(-1, width)
    frames = np.repeat(data[:, None], channels, axis=1).reshape(len(data), -1)
    chunks = np.array_split(frames, 20)
    sent = [AudioChunk(rate, width, channels, chunk.tobytes()).event() for chunk in chunks]
    assert transcribed(uri, *sent, AudioStop().event()) == "go back"


def test_an_error_reaches_who_still_sends(uri: str) -> None:
    async def ask_late() -> list[Event | None]:
        chunk, mistaken = (AudioChunk(RATE, width, 1, bytes(40_000)).event() for width in (2, 5))
        async with AsyncClient.from_uri(uri) as client:
            for event in [mistaken, *[chunk] * 50, AudioStop().event(), Describe().event()]:
                await client.write_event(event)
            await asyncio.sleep(0.3)
            return [await asyncio.wait_for(client.read_event(), PATIENCE) for _ in range(2)]

    error, info = asyncio.run(ask_late())
    assert error
    assert "8 to 32 bits" in Error.from_event(error).text
    assert info
    assert Info.is_type(info.type)


@pytest.mark.parametrize("garbage", [b"\n", b"{}\n", b"[]\n", b"\xff\xfe\n", b'{"type": 3}\n'])
def test_garbage_ends_its_connection_and_nothing_else(uri: str, garbage: bytes) -> None:
    port = int(uri.rpartition(":")[2])
    with closing(socket.create_connection(("127.0.0.1", port), PATIENCE)) as client:
        client.sendall(garbage)
        client.shutdown(socket.SHUT_WR)
        assert client.recv(1000) == b""
    assert asyncio.run(ask(uri, Describe().event()))


@pytest.mark.parametrize("what", ["data_length", "payload_length"])
def test_a_message_that_announces_too_much_is_not_waited_for(uri: str, what: str) -> None:
    port = int(uri.rpartition(":")[2])
    with closing(socket.create_connection(("127.0.0.1", port), PATIENCE)) as client:
        client.sendall(json.dumps({"type": "audio-chunk", what: 10**12}).encode() + b"\n")
        answer = b"".join(iter(partial(client.recv, 1000), b""))
        assert b"an event has 1,000,000,000,000 bytes; send 4,000,000 at most" in answer
    assert asyncio.run(ask(uri, Describe().event()))


@pytest.mark.parametrize("uri", ["tcp://127.0.0.1", "nonsense", "tcp://203.0.113.1:1"])
def test_a_place_that_cannot_be_served_is_one_line(uri: str) -> None:
    done = in_process("serve", "--wyoming", uri)
    assert f"--wyoming {uri}: cannot listen there" in done.complaint
