"""Measure `voz/language/phone_distances.tsv` anew from recordings whose words are known.

Each clip is searched once: for its own phones, and beside them for each variation in which one
phone is replaced by another. What the replacement loses in log-likelihood, for each frame of the
replaced phone, is how far apart the acoustic model holds the two. To count what free phone
recognition mistakes would need far more speech: most pairs are never mistaken, and yet they are
not equally far apart.

A pair that was heard little is drawn towards what articulation says of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pocketsphinx
import typer

from voz.apps.recordings.manifest import read_manifest
from voz.audio import Samples
from voz.audio.sound_files import read_samples
from voz.cli.text_io import with_bar
from voz.errors import VozError
from voz.language.phones import DISTANCES_FILE, PHONE_NAMES
from voz.language.pronunciation import look_up, read_cmudict, split_compound
from voz.language.spoken_language import ENGLISH_MODEL
from voz.recognition.pocketsphinx.decoder import mean_start, nats
from voz.recognition.pocketsphinx.evidence import (
    SILENCE,
    SILENCE_WEIGHT,
    UNPRUNED,
    filler_dictionary,
)

PHONES = PHONE_NAMES.split()
MOST_PHONES = 12
"""The search grows with the square of the phones; all 14 commands are within."""

PRIOR_FRAMES = 50.0
"""How many frames the prior counts for. The result hardly changes between 10 and 500."""

MOST_LOST = 690.0
"""Nats behind the best path at which the widest beam, 1e-300, loses a variation."""

LEAST_DISTANCE = 0.1
"""Two phones are never quite the same."""

# Consonants: manner, place (0 the lips, 1 the throat), voiced.
CONSONANTS = {
    "P": ("stop", 0.0, 0), "B": ("stop", 0.0, 1), "T": ("stop", 0.4, 0), "D": ("stop", 0.4, 1),
    "K": ("stop", 0.8, 0), "G": ("stop", 0.8, 1),
    "CH": ("affricate", 0.55, 0), "JH": ("affricate", 0.55, 1),
    "F": ("fricative", 0.1, 0), "V": ("fricative", 0.1, 1),
    "TH": ("fricative", 0.25, 0), "DH": ("fricative", 0.25, 1),
    "S": ("fricative", 0.4, 0), "Z": ("fricative", 0.4, 1),
    "SH": ("fricative", 0.55, 0), "ZH": ("fricative", 0.55, 1), "HH": ("fricative", 1.0, 0),
    "M": ("nasal", 0.0, 1), "N": ("nasal", 0.4, 1), "NG": ("nasal", 0.8, 1),
    "L": ("glide", 0.4, 1), "R": ("glide", 0.5, 1), "W": ("glide", 0.0, 1), "Y": ("glide", 0.7, 1),
}  # fmt: skip

# Vowels: height and backness (0 low, front; 1 high, back), where the two move to, r-colored.
VOWELS = {
    "IY": (1.0, 0.0, 1.0, 0.0, 0), "IH": (0.8, 0.2, 0.8, 0.2, 0), "EY": (0.6, 0.1, 0.9, 0.1, 0),
    "EH": (0.4, 0.2, 0.4, 0.2, 0), "AE": (0.1, 0.2, 0.1, 0.2, 0), "AA": (0.0, 0.8, 0.0, 0.8, 0),
    "AO": (0.3, 1.0, 0.3, 1.0, 0), "AH": (0.3, 0.6, 0.3, 0.6, 0), "UH": (0.8, 0.8, 0.8, 0.8, 0),
    "UW": (1.0, 0.9, 1.0, 0.9, 0), "OW": (0.5, 1.0, 0.8, 0.9, 0), "AW": (0.0, 0.5, 0.8, 0.9, 0),
    "AY": (0.0, 0.6, 0.9, 0.1, 0), "OY": (0.4, 1.0, 0.9, 0.1, 0), "ER": (0.5, 0.5, 0.5, 0.5, 1),
}  # fmt: skip

MANNERS = {
    frozenset(("stop", "affricate")): 0.3, frozenset(("affricate", "fricative")): 0.3,
    frozenset(("stop", "fricative")): 0.5, frozenset(("nasal", "glide")): 0.5,
    frozenset(("stop", "nasal")): 0.6, frozenset(("stop", "glide")): 0.7,
    frozenset(("fricative", "glide")): 0.7, frozenset(("fricative", "nasal")): 0.7,
    frozenset(("affricate", "nasal")): 0.9, frozenset(("affricate", "glide")): 0.9,
}  # fmt: skip

# A vowel and a consonant have nothing in common, but for these.
HALF_VOWELS = {
    frozenset(("R", "ER")): 0.3, frozenset(("Y", "IY")): 0.4, frozenset(("W", "UW")): 0.4,
    frozenset(("Y", "IH")): 0.6, frozenset(("W", "OW")): 0.6, frozenset(("L", "OW")): 0.6,
    frozenset(("W", "AO")): 0.7, frozenset(("L", "AO")): 0.7, frozenset(("L", "UH")): 0.7,
}  # fmt: skip

Table = npt.NDArray[np.float64]


class Clip(NamedTuple):
    """A recording of known words."""

    path: Path
    phones: list[str]
    speaker: str


class Search(NamedTuple):
    """A graph for one clip: a chain of its phones, and one for each variation."""

    arcs: list[tuple[Any, ...]]  # what pocketsphinx makes the graph from
    states: int  # how many states it has
    # The last state of each variation, by the place and the phone that is put there.
    ends: dict[tuple[int, str], int]


class Losses(NamedTuple):
    """What replacing one phone (row) by another (column) has lost, and over how many frames."""

    nats: Table
    frames: Table
    lengths: list[list[int]]


def articulatory_distance(one: str, other: str) -> float:
    """Guess how far two phones are from each other: 0 the same, 1 nothing in common."""
    pair = frozenset((one, other))
    if one == other:
        return 0.0
    if pair <= CONSONANTS.keys():
        (manner, place, voiced), (manner2, place2, voiced2) = CONSONANTS[one], CONSONANTS[other]
        unlike = MANNERS.get(frozenset((manner, manner2)), 0.0)
        apart = min(1.0, 1.5 * abs(place - place2))
        return min(1.0, 0.1 + 0.6 * unlike + 0.3 * apart + 0.15 * (voiced != voiced2))
    if pair <= VOWELS.keys():
        apart = math.dist(VOWELS[one][:4], VOWELS[other][:4]) / math.sqrt(2)
        return min(1.0, 0.1 + 0.6 * apart + 0.3 * (VOWELS[one][4] != VOWELS[other][4]))
    return HALF_VOWELS.get(pair, 1.0)


def clips(manifest: Path, conditions: Sequence[str]) -> Iterator[Clip]:
    """Go through the recordings of a manifest whose words are all in the dictionary."""
    cmudict = read_cmudict()
    for clip in read_manifest(manifest):
        if conditions and clip.condition not in conditions:
            continue
        phones = pronunciation(cmudict, clip.text)
        if 0 < len(phones) <= MOST_PHONES:
            yield Clip(clip.path, phones, clip.speaker)


def pronunciation(cmudict: bytes, text: str) -> list[str]:
    """Find the usual phones of a text; none if a word of it is unknown."""
    phones: list[str] = []
    for word in text.split():
        parts = (word,) if look_up(cmudict, word) else split_compound(word, _known(cmudict))
        if not parts:
            return []
        for part in parts:
            phones += look_up(cmudict, part)[0].split()
    return phones


def _known(cmudict: bytes) -> Any:
    return lambda word: look_up(cmudict, word)


def variations(phones: Sequence[str]) -> Search:
    """Make the graph for one clip; the phones' own chain ends in the state `len(phones)`."""
    length = len(phones)
    arcs: list[tuple[Any, ...]] = [(i, i + 1, 1.0, f"_{p}") for i, p in enumerate(phones)]
    ends = {}
    state = length + 1
    for place, phone in enumerate(phones):
        for other in PHONES:
            if other == phone:
                continue
            before = place
            for name in (other, *phones[place + 1 :]):
                arcs.append((before, state, 1.0, f"_{name}"))
                before, state = state, state + 1
            ends[place, other] = before
    quiet = (0, length, *ends.values())
    arcs += [(at, at, SILENCE_WEIGHT, SILENCE) for at in quiet]
    return Search(arcs, state, ends)


def measure(chosen: Sequence[Clip]) -> Losses:
    """Search all clips and add up what the variations lose."""
    with filler_dictionary(PHONES) as words:
        decoder = pocketsphinx.Decoder(
            hmm=pocketsphinx.get_model_path(ENGLISH_MODEL),
            dict=None,
            lm=None,
            fdict=str(words),  # as in the phone loop: phones without their context
            fsgusefiller=False,
            ds=2,  # every other frame's Gaussians in full: 0.6 of the time
            bestpath=False,
            beam=UNPRUNED,
            pbeam=UNPRUNED,
            wbeam=UNPRUNED,
            loglevel="FATAL",
        )
    size = len(PHONES)
    losses = Losses(np.zeros((size, size)), np.zeros((size, size)), [[] for _ in PHONES])
    for clip in with_bar(chosen, "Measuring"):
        measure_clip(decoder, clip.phones, read_samples(clip.path), losses)
    return losses


def measure_clip(decoder: Any, phones: list[str], samples: Samples, losses: Losses) -> None:
    """Search one clip and add what it tells."""
    search = variations(phones)
    graph = decoder.create_fsg("variations", 0, len(phones), search.arcs)
    decoder.add_fsg("variations", graph)
    decoder.activate_search("variations")
    decoder.reinit_feat()
    decoder.set_cmn(mean_start(samples))
    decoder.start_utt()
    decoder.process_raw(samples.tobytes())
    decoder.end_utt()
    graph = decoder.get_fsg("variations")
    graph.set_final_state(len(phones))
    own = decoder.hyp()
    if own is None:
        return
    segments = [s for s in decoder.seg() if s.word.startswith("_")]
    lengths = [s.end_frame - s.start_frame + 1 for s in segments]
    for phone, length in zip(phones, lengths, strict=True):
        losses.lengths[PHONES.index(phone)].append(length)
    for (place, other), end in search.ends.items():
        graph.set_final_state(end)
        varied = decoder.hyp()
        loss = nats(own.score) - nats(varied.score) if varied else MOST_LOST
        at = PHONES.index(phones[place]), PHONES.index(other)
        losses.nats[at] += min(max(loss, 0.0), MOST_LOST)
        losses.frames[at] += lengths[place]


def smoothed(losses: Losses) -> Table:
    """Turn the losses into distances, in nats a frame, the same in both directions."""
    prior = np.array([[articulatory_distance(p, q) for q in PHONES] for p in PHONES])
    # The prior is brought to nats by least squares over the frames that were heard.
    scale = (losses.nats * prior).sum() / (losses.frames * prior**2).sum()
    lost, frames = (table + table.T for table in (losses.nats, losses.frames))
    table = (lost + PRIOR_FRAMES * scale * prior) / (frames + PRIOR_FRAMES)
    table = np.maximum(table, LEAST_DISTANCE)
    np.fill_diagonal(table, 0.0)
    return np.asarray(table)


def write(path: Path, table: Table, lengths: Sequence[Sequence[int]], header: str) -> None:
    """Write the table; a phone that was never heard gets the length of the average one."""
    usual = float(np.mean([length for each in lengths for length in each]))
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(header)
        file.write("\t".join(["phone", "frames", *PHONES]) + "\n")
        for phone, each, row in zip(PHONES, lengths, table, strict=True):
            figures = [float(np.mean(each)) if each else usual, *row]
            file.write("\t".join([phone, *(f"{figure:.1f}" for figure in figures)]) + "\n")


def main(
    manifests: Annotated[
        list[Path], typer.Argument(metavar="MANIFEST...", exists=True, dir_okay=False)
    ],
    condition: Annotated[
        list[str] | None, typer.Option(help="Only these recordings; may be repeated.")
    ] = None,
    out: Annotated[
        Path, typer.Option(help="The table.", show_default="in the package")
    ] = DISTANCES_FILE,
) -> None:
    """Measure how far apart the acoustic model holds the phones.

    A manifest is a table with tabs, with columns path (or file), text, speaker (or voice), kind and
    perhaps condition. A second of speech takes about a second.
    """
    try:
        chosen = [clip for manifest in manifests for clip in clips(manifest, condition or [])]
    except VozError as error:
        raise typer.BadParameter(str(error)) from None
    if not chosen:
        raise typer.BadParameter("no recording of known words is left; see --condition")
    losses = measure(chosen)
    speakers = len({clip.speaker for clip in chosen})
    header = (
        f"# How far apart the en-us model of pocketsphinx {version('pocketsphinx')} holds two "
        "phones, in nats for each frame\n"
        "# of 10 ms, and how many frames a phone lasts.\n"
        f"# Measured by tools/fit_confusion.py on {len(chosen)} clips of {speakers} speakers"
        f"{' (' + ', '.join(condition) + ')' if condition else ''}; pairs heard\n"
        "# little lean on place, manner and voicing. See there.\n"
    )
    write(out, smoothed(losses), losses.lengths, header)


if __name__ == "__main__":
    typer.run(main)
