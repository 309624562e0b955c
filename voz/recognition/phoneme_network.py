"""A network that hears phonemes, computed with numpy from the weights in PyPI's `hama`.

That package has an engine of its own, which is built for any processor and takes 70 ms for a second
of sound; numpy takes 4. The tensors are named as their export to ONNX named them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from voz.audio import Samples
from voz.process.one_thread import on_one_thread
from voz.recognition.hama_weights import (
    Floats,
    UnknownNetworkError,
    find_assets,
    read_symbols,
    read_tensors,
)

WINDOW = 400
"""Samples of a spectrum, 25 ms."""

HOP = 160
"""Samples between spectra, 10 ms; the network halves their number."""

MOMENT = 2 * HOP
"""Samples between the moments that it tells of, 20 ms."""

SHORTEST = 6400
"""Samples, 0.4 s; it was made for no less, so what is shorter is filled up with silence."""

FULL_SCALE = 32768

QUIETEST = 1e-10
"""Added up in a band, before the logarithm."""

BLOCKS = 4
HEADS = 4
DEPTHWISE = 31
"""Moments that the convolution of a block looks at."""

TINY = 1e-5
"""Added to a variance."""

ERROR_FUNCTION = (1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592, 0.0)

MODEL = "acoustic_model.model"
FIRST = ("onnx::Conv_801", "onnx::Conv_802")
DEEP = "onnx::Conv_{}"
PRODUCT = "onnx::MatMul_{}"

BESIDES = ("<wb>", "<blank>")
"""The last symbols: between two words, and nothing new."""

BLANKS = len(BESIDES)


class Linear(NamedTuple):
    """Weights that are multiplied, inputs x outputs, and what is added."""

    weight: Floats
    bias: Floats


class ConformerBlock(NamedTuple):
    """A Conformer block: its layers, and the scale and shift of the normalisations before them."""

    norms: Mapping[str, Linear]
    layers: Mapping[str, Linear]


class PhonemeNetwork:
    """The network; made once, used for many.

    Attributes:
        symbols: what it knows, in IPA, with `<wb>` between words and `<blank>` for no new one.
    """

    def __init__(self) -> None:
        """Load the weights; the package is found, not run.

        Raises:
            UnknownNetworkError: it is not installed, or brings another network.
        """
        folder = find_assets()
        found = read_tensors(folder / "asr_waveform.hama")
        self.symbols = (*read_symbols(folder / "g2p_vocab.json"), *BESIDES)
        try:
            self._real, self._imaginary = (
                np.ascontiguousarray(found[f"stft_{part}_kernel"][:, 0].T)
                for part in ("real", "imag")
            )
            self._bands = found["mel_fb"]
            weight, bias = (found[name] for name in FIRST)
            channels = len(bias)
            self._first = Linear(weight.transpose(2, 1, 0).reshape(-1, channels), bias)
            self._blocks = [_block(found, number) for number in range(BLOCKS)]
            self._last = _pointwise(found, f"{MODEL}.proj")
        except (KeyError, ValueError) as error:
            raise UnknownNetworkError(f"its network has other tensors: {error}") from error
        if self._last.bias.shape != (len(self.symbols),):
            raise UnknownNetworkError("its network has other symbols")

    @on_one_thread
    def log_probabilities(self, samples: Samples) -> Floats:
        """Tell what is heard at each moment.

        Args:
            samples: 16 kHz.

        Returns:
            Moments of 20 ms x symbols, natural logarithms.
        """
        missing = max(0, SHORTEST - len(samples))
        bands = self._spectra(np.pad(samples, (0, missing)))
        x = _gelu(_neighbours(bands) @ self._first.weight + self._first.bias)
        for block in self._blocks:
            x = _through(block, x)
        x = x @ self._last.weight + self._last.bias
        x -= x.max(axis=1, keepdims=True)
        x -= np.log(np.exp(x).sum(axis=1, keepdims=True))
        return x

    def _spectra(self, samples: Samples) -> Floats:
        """The logarithms of the energy in each band, each 10 ms."""
        sound = np.pad(samples.astype(np.float32) / FULL_SCALE, WINDOW // 2, mode="reflect")
        windows = np.lib.stride_tricks.sliding_window_view(sound, WINDOW)[::HOP]
        power = (windows @ self._real) ** 2 + (windows @ self._imaginary) ** 2
        logarithms: Floats = np.log(np.maximum(power @ self._bands, QUIETEST))
        return logarithms


def _through(block: ConformerBlock, x: Floats) -> Floats:
    """Half a feed-forward layer, attention, convolution, and the other half."""
    half = np.float32(0.5)
    x = x + half * _feed_forward(block, "ffn1", x)
    x = x + _attention(block, x)
    x = x + _convolution(block, x)
    x = x + half * _feed_forward(block, "ffn2", x)
    return _normalised(x, block.norms["norm"])


def _feed_forward(block: ConformerBlock, name: str, x: Floats) -> Floats:
    inner = _applied(block.layers[f"{name}.fc1"], _normalised(x, block.norms[f"{name}.norm"]))
    return _applied(block.layers[f"{name}.fc2"], inner * _sigmoid(inner))


def _attention(block: ConformerBlock, x: Floats) -> Floats:
    """Every moment asks all the others, in each head; there is no notion of their places."""
    moments, width = x.shape
    size = width // HEADS
    found = _applied(block.layers["attn.in_proj"], _normalised(x, block.norms["attn_norm"]))
    asked, keys, values = found.reshape(moments, 3, HEADS, size).transpose(1, 2, 0, 3)
    alike = asked @ keys.transpose(0, 2, 1) / np.float32(math.sqrt(size))
    shares = np.exp(alike - alike.max(axis=2, keepdims=True))
    shares /= shares.sum(axis=2, keepdims=True)
    mixed = (shares @ values).transpose(1, 0, 2).reshape(moments, width)
    return _applied(block.layers["attn.out_proj"], mixed)


def _convolution(block: ConformerBlock, x: Floats) -> Floats:
    """Channels one by one over time, between two that mix them; half of the first are gates."""
    moments, width = x.shape
    found = _applied(block.layers["conv.pointwise1"], _normalised(x, block.norms["conv.norm"]))
    gated = found[:, :width] * _sigmoid(found[:, width:])
    padded = np.pad(gated, ((DEPTHWISE // 2, DEPTHWISE // 2), (0, 0)))
    deep = block.layers["conv.depthwise"]
    total = np.repeat(deep.bias[np.newaxis], moments, axis=0)
    product = np.empty_like(total)
    for place, weight in enumerate(deep.weight):
        total += np.multiply(padded[place : place + moments], weight, out=product)
    return _applied(block.layers["conv.pointwise2"], total * _sigmoid(total))


def _neighbours(bands: Floats) -> Floats:
    """Put every other spectrum beside the ones before and after it."""
    padded = np.pad(bands, ((1, 1), (0, 0)))
    return np.concatenate([padded[place : place + len(bands) : 2] for place in range(3)], axis=1)


def _applied(layer: Linear, x: Floats) -> Floats:
    found: Floats = x @ layer.weight
    found += layer.bias
    return found


def _normalised(x: Floats, scale: Linear) -> Floats:
    centred: Floats = x - x.mean(axis=1, keepdims=True)
    variance = np.einsum("ij,ij->i", centred, centred) / x.shape[1]
    centred /= np.sqrt(variance + np.float32(TINY))[:, np.newaxis]
    normalised: Floats = centred * scale.weight + scale.bias
    return normalised


def _sigmoid(x: Floats) -> Floats:
    shares: Floats = 1 / (
        1 + np.exp(-np.maximum(x, np.float32(-80)))
    )  # the exponential of more overflows
    return shares


def _gelu(x: Floats) -> Floats:
    """By the error function, as Abramowitz and Stegun's 7.1.26 has it to 1.5e-7."""
    size = np.abs(x) / np.float32(math.sqrt(2))
    t = 1 / (1 + np.float32(0.3275911) * size)
    error = np.copysign(1 - np.polyval(ERROR_FUNCTION, t) * np.exp(-size * size), x)
    found: Floats = (x * (1 + error) / 2).astype(np.float32)
    return found


def _block(found: Mapping[str, Floats], number: int) -> ConformerBlock:
    """Collect a block; its matrices have lost their names, but stand in its order."""
    name = f"{MODEL}.blocks.{number}"
    # A block's six products are numbered 829, 830, 831, 835, 836, 837, and 9 on for the next.
    products = iter([829, 830, 831, 835, 836, 837])
    layers = {
        part: Linear(found[PRODUCT.format(next(products) + 9 * number)], found[f"{name}.{bias}"])
        for part, bias in (
            ("ffn1.fc1", "ffn1.fc1.bias"),
            ("ffn1.fc2", "ffn1.fc2.bias"),
            ("attn.in_proj", "attn.in_proj_bias"),
            ("attn.out_proj", "attn.out_proj.bias"),
            ("ffn2.fc1", "ffn2.fc1.bias"),
            ("ffn2.fc2", "ffn2.fc2.bias"),
        )
    }
    for part in ("conv.pointwise1", "conv.pointwise2"):
        layers[part] = _pointwise(found, f"{name}.{part}")
    deep = found[DEEP.format(804 + 3 * number)][:, 0]
    if deep.shape[1] != DEPTHWISE:
        raise UnknownNetworkError("its convolutions have another length")
    layers["conv.depthwise"] = Linear(
        np.ascontiguousarray(deep.T), found[DEEP.format(805 + 3 * number)]
    )
    norms = {
        part: Linear(found[f"{name}.{part}.weight"], found[f"{name}.{part}.bias"])
        for part in ("ffn1.norm", "attn_norm", "conv.norm", "ffn2.norm", "norm")
    }
    return ConformerBlock(norms, layers)


def _pointwise(found: Mapping[str, Floats], name: str) -> Linear:
    """A convolution that looks at one moment is a product."""
    weight = found[f"{name}.weight"][:, :, 0].T
    return Linear(np.ascontiguousarray(weight), found[f"{name}.bias"])
