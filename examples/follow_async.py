"""Understand a stream by asyncio: arecord -f S16_LE -r 48000 | python follow_async.py."""

import asyncio
import sys
from collections.abc import Iterator
from typing import Any

import numpy
import numpy.typing

import voz


def blocks() -> Iterator[numpy.typing.NDArray[Any]]:
    """Yield arrays; where they come by `async for`, an asynchronous generator will do."""
    while block := sys.stdin.buffer.read(9600):  # 0.1 s
        yield numpy.frombuffer(block, numpy.int16, len(block) // 2)


async def follow() -> None:
    """Print what is said while the event loop goes on."""
    async for heard in voz.load().astream(blocks(), rate=48000):
        print(heard if heard else f"not sure enough: {heard}", flush=True)


asyncio.run(follow())
