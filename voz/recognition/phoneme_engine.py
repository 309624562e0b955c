"""The package `hama` itself, for a version whose network is none that is computed here.

Its session is no part of what its documentation tells of; all that is used of it is here.
"""

from __future__ import annotations

import numpy as np

from voz.audio import Samples
from voz.recognition.hama_weights import Floats, UnknownNetworkError
from voz.recognition.phoneme_network import BESIDES, FULL_SCALE, SHORTEST, PhonemeNetwork


class PhonemeEngine:
    """The same as `PhonemeNetwork`, by the engine of the package, in ten times the time."""

    def __init__(self) -> None:
        """Load its model.

        Raises:
            UnknownNetworkError: it is not installed, or is not what it was.
        """
        try:
            from hama import ASRModel

            self._model = ASRModel()
            self.symbols = tuple(self._model.decoder_tokens)
            self.log_probabilities(np.zeros(SHORTEST, np.int16))
        # It is another version than any that was looked at: whatever fails, it is of no use.
        except Exception as error:
            raise UnknownNetworkError(f"PyPI's `hama` cannot be used: {error}") from error
        if self.symbols[-len(BESIDES) :] != BESIDES:
            raise UnknownNetworkError("PyPI's `hama` has other symbols")

    def log_probabilities(self, samples: Samples) -> Floats:
        """As `PhonemeNetwork.log_probabilities`."""
        padded = np.pad(samples, (0, max(0, SHORTEST - len(samples))))
        sound = (padded / np.float32(FULL_SCALE)).astype(np.float32)[np.newaxis]
        inputs = {"waveform": sound, "waveform_lengths": np.array([sound.shape[1]])}
        found: Floats = self._model.session.run(["log_probs"], inputs)[0][0]
        return found


def load_network() -> PhonemeNetwork | PhonemeEngine:
    """Load the network of the installed package, by the fastest way there is.

    Raises:
        UnknownNetworkError: there is none.
    """
    try:
        return PhonemeNetwork()
    except UnknownNetworkError:
        return PhonemeEngine()
