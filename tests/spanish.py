"""A model of Spanish phones, made of the English one when it is needed, and its dictionary.

Real Spanish models have licences that keep them out of here. This one is in their format, with
`mdef` as text; each of its phones has the Gaussians of an English phone that is near to it.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pocketsphinx

from voz.language.acoustic_model import (
    BYTE_ORDER,
    STATES_PER_PHONE,
    AcousticModel,
    read_phones,
)
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.spoken_language import configured_language
from voz.settings import SpokenLanguage

RULES = Path(__file__).with_name("spanish_rules.txt")
"""How Spanish is read aloud, in the phones of CMUSphinx's model."""

LIKE = {
    "SIL": "SIL", "a": "AA", "b": "B", "ch": "CH", "d": "DH", "e": "EH", "f": "F", "g": "G",
    "gn": "N", "i": "IY", "j": "HH", "k": "K", "l": "L", "ll": "JH", "m": "M", "n": "N", "o": "AO",
    "p": "P", "r": "D", "rr": "R", "s": "S", "t": "T", "u": "UW", "x": "K", "y": "Y", "z": "S",
}  # fmt: skip
"""Of each Spanish phone, as CMUSphinx calls them, an English one. Some are called alike."""

Floats = npt.NDArray[np.float32]


def spanish_model(folder: Path) -> Path:
    """Write the model."""
    english = Path(pocketsphinx.get_model_path("en-us/en-us"))
    known = AcousticModel(english)
    numbers = [read_phones(english).index(phone) for phone in LIKE.values()]
    folder.mkdir(parents=True)
    (folder / "mdef").write_text(_mdef())
    for name, values in (("means", known.means), ("variances", known.variances)):
        (folder / name).write_bytes(_gaussians(values[numbers].astype("<f4")))
    senones = [
        STATES_PER_PHONE * number + state for number in numbers for state in range(STATES_PER_PHONE)
    ]
    (folder / "sendump").write_bytes(_sendump(known.weights[:, :, senones]))
    data = (english / "transition_matrices").read_bytes()
    (folder / "transition_matrices").write_bytes(_transitions(data, numbers))
    (folder / "noisedict").write_text("<s> SIL\n</s> SIL\n<sil> SIL\n")
    parameters = (english / "feat.params").read_text()
    (folder / "feat.params").write_text(parameters)
    return folder


def spanish(folder: Path) -> Path:
    """Write a language as people keep it: the model, a dictionary of a few words."""
    spanish_model(folder / "model_parameters" / "es")
    words = "para p a r a\ngira j i r a\nla l a\nderecha d e r e ch a\nderecha(2) d e r e ch\n"
    (folder / "es.dic").write_text(words + "él e l\naños a gn o s\n", encoding="utf-8")
    return folder


SETTINGS = """\
lm = "{folder}/lm"

[language]
name = "es"

[commands]
"empieza a escuchar" = "start speech"
"deja de escuchar" = "stop speech"
avanza = "go forward"
para = "stop"
"""


def spanish_robot(folder: Path) -> Path:
    """Write a list as espeak-ng pronounces it, and its settings; returns where these are."""
    (folder / "comandos.txt").write_text("empieza a escuchar\ndeja de escuchar\navanza\npara\n")
    (folder / "voz.toml").write_text(SETTINGS.format(folder=folder))
    spoken = configured_language(SpokenLanguage(name="es"))
    build(folder / "comandos.txt", folder / "lm", read_list(folder / "comandos.txt", spoken))
    return folder / "voz.toml"


def _mdef() -> str:
    size = len(LIKE)
    head = ["n_base", "n_tri", "n_state_map", "n_tied_state", "n_tied_ci_state", "n_tied_tmat"]
    counts = [size, 0, 4 * size, STATES_PER_PHONE * size, STATES_PER_PHONE * size, size]
    lines = ["0.3", *(f"{count} {name}" for count, name in zip(counts, head, strict=True)), "#"]
    for number, phone in enumerate(LIKE):
        kind = "filler" if phone == "SIL" else "n/a"
        states = " ".join(
            str(STATES_PER_PHONE * number + state) for state in range(STATES_PER_PHONE)
        )
        lines.append(f"{phone} - - - {kind} {number} {states} N")
    return "".join(f"{line}\n" for line in lines)


def _gaussians(values: Floats) -> bytes:
    phones, streams, gaussians, size = values.shape
    head = struct.pack("<I3i", BYTE_ORDER, phones, streams, gaussians)
    lengths = struct.pack(f"<{streams}i", *[size] * streams)
    return (
        b"s3\nversion 1.0\nendhdr\n"
        + head
        + lengths
        + struct.pack("<i", values.size)
        + values.tobytes()
    )


def _sendump(weights: npt.NDArray[np.uint8]) -> bytes:
    texts = ["a model for tests", "cluster_count 0", "codebook_count 1", "feature_count 3"]
    head = b"".join(struct.pack("<i", len(t) + 1) + t.encode() + b"\0" for t in texts)
    _, rows, senones = weights.shape
    return head + struct.pack("<3i", 0, rows, senones) + weights.tobytes()


def _transitions(data: bytes, numbers: list[int]) -> bytes:
    at = data.index(b"endhdr\n") + 7
    _, phones, states, targets, _ = struct.unpack_from("<I4i", data, at)
    every = np.frombuffer(data, "<f4", phones * states * targets, at + 20)
    chosen = every.reshape(phones, states, targets)[numbers]
    head = struct.pack("<I4i", BYTE_ORDER, len(numbers), states, targets, chosen.size)
    return b"s3\nversion 1.0\nendhdr\n" + head + chosen.tobytes()
