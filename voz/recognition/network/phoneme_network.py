"""The phoneme network, computed with numpy (4 ms for a second of sound), and its file."""

from __future__ import annotations

import math
import os
import stat
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.files import atomic_write, open_to_read, sha256, shown_path
from voz.process.one_thread import on_one_thread

Floats32 = npt.NDArray[np.float32]

DEFAULT_NETWORK = Path(__file__).with_name("phonemes.npz")
"""The network of voz; `training/` makes such files."""

OTHER_LANGUAGES = Path(__file__).with_name("other_languages.npz")
"""The network of voz for other languages than English: what differs from the one above."""

DESCRIPTION = "description"
"""Entry with the `Description` in JSON, as bytes."""

FINGERPRINT_DIGITS = 12

READ_BYTES = 65_536

MAX_NETWORK_BYTES = 64_000_000
"""Of a file, and of what it unpacks to; the network of voz has 4 million."""


class UnknownNetworkError(Exception):
    """There is no such file, or voz cannot compute the network in it."""


class Description(msgspec.Struct, forbid_unknown_fields=True):
    """What a file of weights says of itself.

    Attributes:
        symbols: in IPA, with `<wb>` and `<blank>` last.
        origin: of the weights.
        license: of the weights.
        base: the fingerprint of `DEFAULT_NETWORK`, if a file has only what differs from it.
    """

    symbols: list[str]
    origin: str
    license: str = msgspec.field(name="licence")  # as files have it
    base: str | None = None


class NetworkFile(NamedTuple):
    """The tensors of a file by name, as in `training/network.py`, and what identifies the file."""

    weights: dict[str, Floats32]
    description: Description
    fingerprint: str


def read_network(path: Path) -> NetworkFile:
    """Read a `.npz` file with an entry for each tensor; raises UnknownNetworkError.

    What a file with a base lacks is read from `DEFAULT_NETWORK`.
    """
    try:
        with open_to_read(path) as file:
            weights = _read_arrays(file)
            if DESCRIPTION not in weights:
                raise ValueError("it has no description")
            description = msgspec.json.decode(weights.pop(DESCRIPTION).tobytes(), type=Description)
            for name, tensor in weights.items():
                # One after the other: all of them in both precisions would take 4 MB more.
                weights[name] = _finite(name, tensor)
            file.seek(0)
            identity = fingerprint(file)
        if description.base:
            weights = _base(description.base) | weights
    except Exception as error:  # of a broken archive there are many kinds
        why = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise UnknownNetworkError(
            f"{shown_path(path)}: holds no phoneme network ({why})"
        ) from error
    return NetworkFile(weights, description, identity)


def _base(wanted: str) -> dict[str, Floats32]:
    """The tensors of `DEFAULT_NETWORK`; raises ValueError if it is not the one that is wanted."""
    found = read_network(DEFAULT_NETWORK)
    if found.fingerprint != wanted:
        raise ValueError(f"it completes network {wanted}, and voz has {found.fingerprint}")
    return found.weights


def _read_arrays(file: IO[bytes]) -> dict[str, npt.NDArray[Any]]:
    """Read an `.npz` file, nothing of which is made before its size is known; raises ValueError."""
    status = os.fstat(file.fileno())
    if not stat.S_ISREG(status.st_mode):
        raise ValueError("it is no regular file")
    with zipfile.ZipFile(file) as archive:
        entries = archive.infolist()
        if max(status.st_size, sum(entry.file_size for entry in entries)) > MAX_NETWORK_BYTES:
            raise ValueError(f"it is larger than {MAX_NETWORK_BYTES:,} bytes")
        return {
            entry.filename.removesuffix(".npy"): _read_array(archive, entry) for entry in entries
        }


def _read_array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> npt.NDArray[Any]:
    """Read an entry of numbers whose header fits its size."""
    read_header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    with archive.open(entry) as content:
        version = np.lib.format.read_magic(content)
        if version not in read_header:
            raise ValueError(f"{entry.filename} is of version {version}")
        shape, columns_first, kind = read_header[version](content)
        size = entry.file_size - content.tell()
        if kind.kind not in "fu" or min(shape, default=1) < 1:
            raise ValueError(f"{entry.filename} holds no numbers")
        if math.prod(shape) * kind.itemsize != size:
            raise ValueError(f"{entry.filename} has another size than it claims")
        numbers = np.frombuffer(content.read(), kind)
    return numbers.reshape(shape, order="F" if columns_first else "C")


def _finite(name: str, tensor: npt.NDArray[Any]) -> Floats32:
    with np.errstate(over="ignore"):  # of 64 bits
        numbers: Floats32 = tensor.astype(np.float32)
    if not np.isfinite(numbers).all():
        raise ValueError(f"{name} holds what is no number")
    return numbers


def write_network(path: Path, weights: dict[str, Floats32], description: Description) -> None:
    """Write a file of weights, in half precision."""
    entries: dict[str, Any] = {name: tensor.astype(np.float16) for name, tensor in weights.items()}
    entries[DESCRIPTION] = np.frombuffer(msgspec.json.encode(description), np.uint8)
    with atomic_write(path, "wb") as file:  # who is killed meanwhile keeps the old one
        np.savez(file, **entries)


def fingerprint_of(path: Path) -> str:
    """The fingerprint of a file of weights."""
    with path.open("rb") as file:
        return fingerprint(file)


def fingerprint(file: IO[bytes]) -> str:
    """The first digits of the SHA-256 of a file's content."""
    digest = sha256()
    while block := file.read(READ_BYTES):
        digest.update(block)
    return digest.hexdigest()[:FINGERPRINT_DIGITS]


WINDOW = 400
"""Samples of a spectrum, 25 ms."""

HOP = 160
"""Samples between spectra, 10 ms; the network halves their number."""

MOMENT = 2 * HOP
"""Samples between outputs, 20 ms."""

SHORTEST = 6400
"""Samples, 0.4 s; shorter sound is padded."""

FULL_SCALE = 32768

QUIETEST = 1e-10
"""Floor of the energy in a band."""

LONGEST_WINDOW = int(2.4 * SAMPLE_RATE)
"""Samples: the attention knows no places, and amid more speech it loses the phones of the end."""

WINDOW_EDGE = 30 * MOMENT
"""Samples at either end of a window that another window hears better, 0.6 s."""

BLOCKS = 4
HEADS = 4
DEPTHWISE = 31
"""Moments in the convolution of a block."""

TINY = 1e-5
"""Added to a variance."""

# Like noise, but without numpy.random, which loads OpenSSL: 3 MB.
_PROBE: Samples = (np.arange(SHORTEST) ** 2 * 7919 % 16001 - 8000).astype(np.int16)
"""Noise that any network can hear."""

ERROR_FUNCTION = (1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592, 0.0)

NORMS = ("ffn1.norm", "attn.norm", "conv.norm", "ffn2.norm", "last.norm")
LAYERS = (
    *("ffn1.fc1", "ffn1.fc2", "attn.in_proj", "attn.out_proj"),
    *("conv.pointwise1", "conv.depthwise", "conv.pointwise2", "ffn2.fc1", "ffn2.fc2"),
)
"""Parts of a block, by their names in the file of weights."""

BLANK_SYMBOLS = ("<wb>", "<blank>")
"""The last symbols: between two words, and no new symbol."""

BLANKS = len(BLANK_SYMBOLS)


class Linear(NamedTuple):
    """Weights, inputs x outputs, and bias."""

    weight: Floats32
    bias: Floats32


@dataclass(frozen=True)
class ConformerBlock:
    """Layers, and scale and shift of the normalizations before them."""

    norms: Mapping[str, Linear]
    layers: Mapping[str, Linear]


class PhonemeNetwork:
    """The network; its outputs are `symbols`, in IPA, with `BLANK_SYMBOLS` last."""

    def __init__(self, path: Path = DEFAULT_NETWORK) -> None:
        """Load a file of weights; raises UnknownNetworkError."""
        weights, description, self.fingerprint = read_network(path)
        self.symbols = tuple(description.symbols)
        if why := _misfit(weights, self.symbols):
            raise UnknownNetworkError(f"{shown_path(path)}: {why}")
        self._real, self._imaginary = spectrum_kernels()
        self._bands = weights["bands"]
        self._first, self._last = (_layer(weights, name) for name in ("first", "last"))
        self._blocks = [_block(weights, number) for number in range(BLOCKS)]
        with np.errstate(all="ignore"):
            heard = self.log_probabilities(_PROBE)
        if not np.isfinite(heard).all() or not np.ptp(heard, axis=0).any():
            raise UnknownNetworkError(f"{shown_path(path)}: has weights that hear nothing")

    @on_one_thread
    def log_probabilities(self, samples: Samples) -> Floats32:
        """Compute log-probabilities, moments of 20 ms x symbols, of samples of 16 kHz."""
        missing = max(0, SHORTEST - len(samples))
        bands = self._spectra(np.pad(samples, (0, missing)))
        x = _gelu(_neighbors(bands) @ self._first.weight + self._first.bias)
        for block in self._blocks:
            x = _through(block, x)
        x = x @ self._last.weight + self._last.bias
        x -= x.max(axis=1, keepdims=True)
        x -= np.log(np.exp(x).sum(axis=1, keepdims=True))
        return x

    def log_probabilities_in_windows(self, samples: Samples) -> Floats32:
        """Compute the same of a sentence of any length."""
        inner = len(samples) - 2 * WINDOW_EDGE
        windows = math.ceil(inner / (LONGEST_WINDOW - 2 * WINDOW_EDGE))
        if windows <= 1:
            return self.log_probabilities(samples)
        step = math.ceil(inner / windows / MOMENT)
        edge = WINDOW_EDGE // MOMENT
        found: list[Floats32] = []
        for number in range(windows):
            window = samples[number * step * MOMENT :][: step * MOMENT + 2 * WINDOW_EDGE]
            first = edge if number else 0
            last = edge + step if number < windows - 1 else None
            found.append(self.log_probabilities(window)[first:last])
        return np.concatenate(found)

    def _spectra(self, samples: Samples) -> Floats32:
        """Logarithms of the energy, spectra x bands."""
        sound = np.pad(samples.astype(np.float32) / FULL_SCALE, WINDOW // 2, mode="reflect")
        windows = np.lib.stride_tricks.sliding_window_view(sound, WINDOW)[::HOP]
        power = (windows @ self._real) ** 2 + (windows @ self._imaginary) ** 2
        logarithms: Floats32 = np.log(np.maximum(power @ self._bands, QUIETEST))
        return logarithms


def _through(block: ConformerBlock, x: Floats32) -> Floats32:
    """Half a feed-forward layer, attention, convolution, and the other half."""
    half = np.float32(0.5)
    x = x + half * _feed_forward(block, "ffn1", x)
    x = x + _attention(block, x)
    x = x + _convolution(block, x)
    x = x + half * _feed_forward(block, "ffn2", x)
    return _normalized(x, block.norms["last.norm"])


def _feed_forward(block: ConformerBlock, name: str, x: Floats32) -> Floats32:
    inner = _applied(block.layers[f"{name}.fc1"], _normalized(x, block.norms[f"{name}.norm"]))
    return _applied(block.layers[f"{name}.fc2"], inner * _sigmoid(inner))


def _attention(block: ConformerBlock, x: Floats32) -> Floats32:
    """Attention over all moments, without their positions."""
    moments, width = x.shape
    size = width // HEADS
    found = _applied(block.layers["attn.in_proj"], _normalized(x, block.norms["attn.norm"]))
    asked, keys, values = found.reshape(moments, 3, HEADS, size).transpose(1, 2, 0, 3)
    alike = asked @ keys.transpose(0, 2, 1) / np.float32(math.sqrt(size))
    shares = np.exp(alike - alike.max(axis=2, keepdims=True))
    shares /= shares.sum(axis=2, keepdims=True)
    mixed = (shares @ values).transpose(1, 0, 2).reshape(moments, width)
    return _applied(block.layers["attn.out_proj"], mixed)


def _convolution(block: ConformerBlock, x: Floats32) -> Floats32:
    """A gated depthwise convolution between two pointwise ones."""
    moments, width = x.shape
    found = _applied(block.layers["conv.pointwise1"], _normalized(x, block.norms["conv.norm"]))
    gated = found[:, :width] * _sigmoid(found[:, width:])
    padded = _between_zeros(gated, DEPTHWISE // 2)
    deep = block.layers["conv.depthwise"]
    total = np.repeat(deep.bias[np.newaxis], moments, axis=0)
    product = np.empty_like(total)
    for place, weight in enumerate(deep.weight):
        total += np.multiply(padded[place : place + moments], weight, out=product)
    return _applied(block.layers["conv.pointwise2"], total * _sigmoid(total))


def _neighbors(bands: Floats32) -> Floats32:
    """Put every other spectrum beside the ones before and after it."""
    padded = _between_zeros(bands, 1)
    return np.concatenate([padded[place : place + len(bands) : 2] for place in range(3)], axis=1)


def _between_zeros(x: Floats32, rows: int) -> Floats32:
    """As np.pad does, in a third of its time."""
    padded = np.zeros((len(x) + 2 * rows, x.shape[1]), np.float32)
    padded[rows : rows + len(x)] = x
    return padded


def _applied(layer: Linear, x: Floats32) -> Floats32:
    found: Floats32 = x @ layer.weight
    found += layer.bias
    return found


def _normalized(x: Floats32, scale: Linear) -> Floats32:
    width = np.float32(x.shape[1])
    centered: Floats32 = x - x.sum(axis=1, keepdims=True) / width
    variance = np.einsum("ij,ij->i", centered, centered) / width
    centered /= np.sqrt(variance + np.float32(TINY))[:, np.newaxis]
    centered *= scale.weight
    centered += scale.bias
    return centered


def _sigmoid(x: Floats32) -> Floats32:
    shares: Floats32 = np.maximum(x, np.float32(-80))  # the exponential of more overflows
    np.exp(np.negative(shares, out=shares), out=shares)
    shares += 1
    return np.reciprocal(shares, out=shares)


def _gelu(x: Floats32) -> Floats32:
    """GELU by Abramowitz and Stegun's error function 7.1.26, exact to 1.5e-7."""
    size = np.abs(x) / np.float32(math.sqrt(2))
    t = 1 / (1 + np.float32(0.3275911) * size)
    error = np.copysign(1 - np.polyval(ERROR_FUNCTION, t) * np.exp(-size * size), x)
    found: Floats32 = (x * (1 + error) / 2).astype(np.float32)
    return found


def spectrum_kernels() -> tuple[Floats32, Floats32]:
    """Real and imaginary part of a Fourier transform with a Hann window; samples x frequencies."""
    place = np.arange(WINDOW)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * place / WINDOW)
    angle = 2 * np.pi / WINDOW * np.outer(place, np.arange(WINDOW // 2 + 1))
    real, imaginary = (window[:, np.newaxis] * part for part in (np.cos(angle), -np.sin(angle)))
    return real.astype(np.float32), imaginary.astype(np.float32)


def _misfit(weights: Mapping[str, Floats32], symbols: Sequence[str]) -> str | None:
    """Why tensors are not those of the network; None if they are."""
    for name, shape in _shapes(weights, len(symbols)).items():
        if name not in weights:
            return f"holds no tensor {name!r}"
        if name == "last.bias" and weights[name].shape != shape:
            return "has symbols that do not fit its weights"
        if weights[name].shape != shape:
            return f"has a tensor {name} of shape {weights[name].shape} in place of {shape}"
    if tuple(symbols[-BLANKS:]) != BLANK_SYMBOLS or len(set(symbols)) != len(symbols):
        return "has symbols that are none of a network of voz"
    return None


def _shapes(weights: Mapping[str, Floats32], symbols: int) -> dict[str, tuple[int, ...]]:
    """The shape of each tensor, by the widths of some of them and the number of symbols."""

    def last_size(name: str) -> int:
        return weights[name].shape[-1] if name in weights and weights[name].ndim else 0

    bands, inner = last_size("bands"), last_size("blocks.0.ffn1.fc1.bias")
    width = last_size("first.bias") // HEADS * HEADS
    layers = {
        "ffn1.fc1": (width, inner),
        "ffn1.fc2": (inner, width),
        "attn.in_proj": (width, 3 * width),
        "attn.out_proj": (width, width),
        "conv.pointwise1": (width, 2 * width),
        "conv.depthwise": (DEPTHWISE, width),
        "conv.pointwise2": (width, width),
        "ffn2.fc1": (width, inner),
        "ffn2.fc2": (inner, width),
    }
    whole = {"first": (3 * bands, width), "last": (width, symbols)}
    for number in range(BLOCKS):
        whole |= {f"blocks.{number}.{name}": layers[name] for name in LAYERS}
    shapes: dict[str, tuple[int, ...]] = {"bands": (WINDOW // 2 + 1, bands)}
    for name, (inputs, outputs) in whole.items():
        shapes |= {f"{name}.bias": (outputs,), f"{name}.weight": (inputs, outputs)}
    for name in (f"blocks.{number}.{norm}" for number in range(BLOCKS) for norm in NORMS):
        shapes |= {f"{name}.weight": (width,), f"{name}.bias": (width,)}
    return shapes


def _block(weights: Mapping[str, Floats32], number: int) -> ConformerBlock:
    norms, layers = (
        {name: _layer(weights, f"blocks.{number}.{name}") for name in names}
        for names in (NORMS, LAYERS)
    )
    return ConformerBlock(norms, layers)


def _layer(weights: Mapping[str, Floats32], name: str) -> Linear:
    return Linear(weights[f"{name}.weight"], weights[f"{name}.bias"])
