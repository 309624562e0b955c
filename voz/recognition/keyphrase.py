"""How well a phrase fits a sound by the acoustic model of pocketsphinx."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pocketsphinx

from voz.audio import Samples
from voz.language.spoken_language import ENGLISH_MODEL

LEAST_PROBABILITY = 1e-300
"""What is less likely is not found; pocketsphinx's own limits keep only what is nearly sure."""

SCALE = 1024
"""pocketsphinx keeps 1/1024 of the logarithm of a probability."""


class KeyphraseScorer:
    """Scores a phrase in sounds."""

    def __init__(self, phones: Sequence[str]) -> None:
        """Load the English acoustic model for a phrase of some of its phones."""
        self._phones = len(phones)
        self._decoder = pocketsphinx.Decoder(
            hmm=pocketsphinx.get_model_path(ENGLISH_MODEL),
            dict=None,
            lm=None,
            cmn="batch",  # the mean of the sound itself, not of those before
            remove_noise=False,  # it would have to hear the noise for longer first
            beam=LEAST_PROBABILITY,
            kws_threshold=LEAST_PROBABILITY,
            kws_delay=1,  # ends at the end of a sound, too
            loglevel="FATAL",
        )
        self._decoder.add_word("phrase", " ".join(phones), True)
        self._decoder.add_keyphrase("phrase", "phrase")
        self._decoder.activate_search("phrase")

    def score(self, samples: Samples) -> float:
        """The log-likelihood of the phrase where it fits best, against that of any phones.

        It is the same whatever was heard before.

        Args:
            samples: the sound, 16 kHz; at least one.

        Returns:
            Nats for each phone; at most 0.
        """
        self._decoder.reinit_feat()  # else a sound's first frames depend on those heard before
        self._decoder.start_utt()
        self._decoder.process_raw(samples.tobytes(), full_utt=True)
        self._decoder.end_utt()
        found = [SCALE * math.log(segment.prob) for segment in self._decoder.seg() or ()]
        return max(found, default=math.log(LEAST_PROBABILITY)) / self._phones
