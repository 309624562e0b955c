"""Which English texts the network reads otherwise than the dictionary has them.

    python training/words.py FOLDER --network taught/best.npz > words.tsv

One line for each text of the folder's manifest, the worst first: the dictionary's phones, how many
clips, the share of phones that are read wrongly, and the commonest reading.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from itertools import chain
from pathlib import Path
from typing import Annotated

import numpy as np
import torch
import typer
from jiwer import wer
from loss import Phones
from mixing import at_level
from network import Network
from speech import ENGLISH, load_pools, read, sounds_of

from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.recognition.network.phoneme_network import DEFAULT_NETWORK, read_network

PADDING_SAMPLES = SAMPLE_RATE // 4
"""Samples of silence before and after each clip."""


def words(
    folder: Annotated[Path, typer.Argument(help="With a manifest.tsv, as for teach.py.")],
    network: Annotated[Path, typer.Option(help="A file of weights.")] = DEFAULT_NETWORK,
) -> None:
    """Print how far the network's reading of each text is from the dictionary's."""
    pool, held_back = load_pools([folder])
    every = chain(*pool.groups, held_back)
    clips = [clip for clip in every if clip.phones and clip.language == ENGLISH]
    file = read_network(network)
    loaded = Network(file.weights).eval()
    phones = Phones(file.description.symbols, sounds_of(ENGLISH), torch.device("cpu"))
    readings: dict[str, list[str]] = defaultdict(list)
    for clip in with_bar(clips, "Reading"):
        sound = np.pad(at_level(read(clip.path)), PADDING_SAMPLES)
        with torch.no_grad():
            symbols = loaded(torch.tensor(sound)[None])[0]
        readings[" ".join(clip.phones or ())].append(phones.reading(symbols))
    rows = [(wer([wanted] * len(found), found), wanted) for wanted, found in readings.items()]
    for errors, wanted in sorted(rows, reverse=True):
        found = readings[wanted]
        (usual, _), *_ = Counter(found).most_common(1)
        print(wanted, len(found), f"{errors:.2f}", usual, sep="\t")
    mean = np.average([errors for errors, _ in rows], weights=[len(readings[w]) for _, w in rows])
    typer.echo(f"{len(clips)} clips: {mean:.3f} of a clip's phones are read wrongly", err=True)


if __name__ == "__main__":
    typer.run(words)
