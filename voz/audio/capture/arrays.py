"""Converts arrays of any rate and channels, floats or 16 bits, to `Samples`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from voz.audio import Samples
from voz.audio.capture.resampling import Mono, Resampler
from voz.audio.capture.sound_files import MAX_SAMPLE_RATE, MIN_SAMPLE_RATE
from voz.errors import AudioError
from voz.printable import shown_value
from voz.records import is_finite

MAX_CHANNELS = 64

MAX_FLOAT_SAMPLE = 4.0
"""Floats beyond this are 16-bit values that were not scaled."""


class ArrayConverter:
    """Converts a stream of arrays to `Samples`, block by block."""

    def __init__(self, rate: float | None) -> None:
        """Start a stream of arrays at a rate, Hz; raises AudioError if the rate is unusable."""
        if rate is None:
            raise AudioError("an array does not hold its sample rate; give it, as in rate=44100")
        if not _is_usable(rate):
            raise AudioError(
                f"a sample rate of {shown_value(rate)} Hz is not usable; give one from "
                f"{MIN_SAMPLE_RATE} to {MAX_SAMPLE_RATE} Hz"
            )
        self._resampler = Resampler(rate)
        self._finished = False

    def feed(self, array: npt.ArrayLike) -> Samples:
        """Convert samples, or samples x channels: int16, or floats from -1 to 1.

        Returns the mean of the channels; its last samples may come later. Raises AudioError.
        """
        if self._finished:
            raise AudioError("this stream is finished; begin another one")
        return self._resampler.feed(_mono(_as_array(array)))

    def finish(self) -> Samples:
        """End the stream; return its last samples, at a second call none."""
        if self._finished:
            return np.empty(0, np.int16)
        self._finished = True
        return self._resampler.finish()


def to_samples(array: npt.ArrayLike, rate: float | None) -> Samples:
    """Convert a whole recording; arguments and errors are those of `ArrayConverter`."""
    converter = ArrayConverter(rate)
    return np.concatenate([converter.feed(array), converter.finish()])


def _is_usable(rate: object) -> bool:
    return is_finite(rate) and MIN_SAMPLE_RATE <= float(rate) <= MAX_SAMPLE_RATE  # type: ignore[arg-type]


def _as_array(array: npt.ArrayLike) -> npt.NDArray[Any]:
    try:
        return np.asarray(array)
    except (TypeError, ValueError, OverflowError) as error:  # rows of different lengths, for one
        raise AudioError(f"this is no array ({error})", "give samples x channels") from None


def _mono(array: npt.NDArray[Any]) -> Mono:
    if array.ndim not in (1, 2):
        raise AudioError(f"an array of shape {array.shape} is no sound; give samples x channels")
    if array.ndim == 2 and not 0 < array.shape[1] <= MAX_CHANNELS:
        raise AudioError(f"an array of shape {array.shape} is no samples x channels; turn it round")
    if array.dtype == np.int16:
        scaled = array.astype(np.float32) / np.float32(32768)
    elif array.dtype.kind == "f":
        scaled = _checked(array).astype(np.float32)
    else:
        raise AudioError(f"samples are {array.dtype}; give int16, or floats from -1 to 1")
    mono: Mono = scaled if scaled.ndim == 1 else scaled.mean(axis=1)
    return mono


def _checked(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if not np.isfinite(array).all():
        raise AudioError("the sound holds samples that are no numbers; leave them out")
    loudest = float(np.abs(array).max(initial=0))
    if loudest > MAX_FLOAT_SAMPLE:
        raise AudioError(f"floats go from -1 to 1, and one is {loudest:g}; divide by 32768?")
    return array
