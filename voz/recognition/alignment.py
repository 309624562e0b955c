"""How far what was heard, phone by phone, is from what a command is made of: pure."""

from __future__ import annotations

from collections.abc import Sequence

from voz.language.confusion import Distances, read_distances

SKIPPED = 2.4
"""Nats for each frame that a phone of the command usually takes, when it is not heard."""

ADDED = 4.0
"""Nats at most for each frame of a phone that is heard besides."""

LONGEST_ADDED = 10
"""Frames of it that count: a phone that is drawn out is one phone too many, not three."""

DRAWN_OUT = 1.5
"""A phone counts for at most so many times its usual length."""

Heard = tuple[str, int]
"""A phone, and how many frames it takes."""


def distance(said: Sequence[str], heard: Sequence[Heard]) -> float:
    """Align the phones of a command with those that were heard.

    Unlike the likelihoods of the command's own path, this looks at what the sound is when nobody
    asks for a command, and weighs each confusion by how alike the model holds the two phones.

    Args:
        said: the phones of the command.
        heard: what the phone loop found where the command was.

    Returns:
        The least loss of any alignment, nats.
    """
    distances = read_distances()
    row = [0.0]
    for _, frames in heard:
        row.append(row[-1] + ADDED * min(frames, LONGEST_ADDED))
    for phone in said:
        row = _next_row(phone, heard, row, distances)
    return row[-1]


def _next_row(
    phone: str, heard: Sequence[Heard], row: Sequence[float], distances: Distances
) -> list[float]:
    """The least losses after one more phone of the command, for each number of phones heard."""
    usual, apart = distances.frames[phone], distances.apart[phone]
    losses = [row[0] + SKIPPED * usual]
    for number, (other, frames) in enumerate(heard):
        taken = row[number] + apart[other] * min(frames, DRAWN_OUT * usual)
        skipped = row[number + 1] + SKIPPED * usual
        besides = losses[-1] + min(ADDED, apart[other]) * min(frames, LONGEST_ADDED)
        losses.append(min(taken, skipped, besides))
    return losses
