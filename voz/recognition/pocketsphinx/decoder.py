"""pocketsphinx and its settings: the sentence of an utterance, and how well a phrase fits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pocketsphinx

from voz.audio import Samples
from voz.audio.denoise import frame_energies
from voz.errors import LanguageError
from voz.language.grammar import to_fsg
from voz.language.spoken_language import ENGLISH_MODEL
from voz.recognition.language import Language, added
from voz.settings import Search

INITIAL_CEPSTRAL_MEAN = (45.0, 3.0, -1.0)
"""First cepstral mean at the usual level; a command is too short to estimate it. The rest is 0."""

USUAL_LEVEL = 47.2
"""Mean level (dB) of a command with its margins that `INITIAL_CEPSTRAL_MEAN` fits."""

LEVEL_WEIGHT = 0.66
"""Change of the mean's first coefficient for each dB of level."""

WIDE_BEAMS = {"beam": 1e-80, "pbeam": 1e-80, "wbeam": 1e-60}
"""Of the search by a grammar; pocketsphinx's own lose sentences of long lists."""

CHUNK = 800
"""Samples decoded at a time; Python's other threads wait meanwhile, 3 ms."""


class Decoder:
    """Finds the sentence of an utterance."""

    def __init__(
        self, language: Language, search: Search = "grammar", *, is_wide: bool = True
    ) -> None:
        """Load the model; LanguageError if pocketsphinx cannot use the language files.

        The search "grammar" gives whole commands only, "lm" any sequence of their words. A wide
        one takes a sixth more CPU and keeps what begins badly.
        """
        # The lattice search that `bestpath` turns on loses a grammar's end, and with it the result.
        beams = WIDE_BEAMS if is_wide and search != "lm" else {}
        self._decoder = load_decoder(language, bestpath=search == "lm", **beams)
        files = language.files
        source = files.lm if search == "lm" else files.grammar
        try:
            if search == "lm":
                self._decoder.add_lm_file("commands", str(source))
            elif language.commands.can_be_listed:
                self._decoder.add_jsgf_file("commands", str(source))
            else:  # the grammar says the same, and takes a hundred times the memory
                arcs, end = to_fsg(language.commands.automaton)
                found = self._decoder.create_fsg("commands", 0, end, arcs)
                self._decoder.add_fsg("commands", found)
            self._decoder.activate_search("commands")
        except (RuntimeError, ValueError, KeyError) as error:
            raise LanguageError(_unusable(source)) from error

    def decode(self, samples: Samples, start: str) -> str:
        """The sentence (lower case, empty if none fits) of samples of 16 kHz and a `mean_start`."""
        process(self._decoder, samples, start)
        hypothesis = self._decoder.hyp()
        return str(hypothesis.hypstr) if hypothesis else ""


def load_decoder(language: Language, **settings: Any) -> Any:
    """Load acoustic model and dictionary with accents, and no search; raises LanguageError.

    The settings are what differs from pocketsphinx's defaults.
    """
    spoken = language.spoken
    config = pocketsphinx.Config(
        hmm=str(spoken.folder(language.files.folder)),
        dictcase=not spoken.uses_default_model,  # phones of others may differ in their case alone
        dict=str(language.files.dictionary),
        lm=None,
        loglevel="FATAL",  # its own messages are about its insides; ours say what to do
        **settings,
    )
    try:
        decoder = pocketsphinx.Decoder(config)
        for word, phones in added(language.dictionary, language.pocketsphinx_words).items():
            decoder.add_word(word, " ".join(phones), False)
    except (RuntimeError, ValueError) as error:
        raise LanguageError(_unusable(language.files.dictionary)) from error
    return decoder


def _unusable(path: object) -> str:
    return f"{path}: cannot be used; make the language files again with `voz build-lm`"


def mean_start(samples: Samples) -> str:
    """The first cepstral mean for samples of 16 kHz by their level, as `set_cmn` reads it."""
    found = frame_energies(samples)
    louder = float(found.mean()) - USUAL_LEVEL if len(found) else 0.0
    first, *others = INITIAL_CEPSTRAL_MEAN
    return ",".join(f"{value:.2f}" for value in (first + LEVEL_WEIGHT * louder, *others))


def process(decoder: Any, samples: Samples, start: str) -> None:
    """Decode one utterance, independently of the ones before."""
    decoder.reinit_feat()
    decoder.set_cmn(start)
    decoder.start_utt()
    for at in range(0, len(samples), CHUNK):
        decoder.process_raw(samples[at : at + CHUNK].tobytes())
    decoder.end_utt()


def nats(score: float) -> float:
    """A score that pocketsphinx's Python gives as e to the 1/1024 of a log-likelihood (`hmm.h`)."""
    return 1024 * math.log(score)


LEAST_PROBABILITY = 1e-300
"""What is less likely is not found; pocketsphinx's own limits keep only what is nearly sure."""


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

        It is in nats for each phone, at most 0, and the same whatever was heard before. There must
        be a sample at least.
        """
        self._decoder.reinit_feat()  # else a sound's first frames depend on those heard before
        self._decoder.start_utt()
        self._decoder.process_raw(samples.tobytes(), full_utt=True)
        self._decoder.end_utt()
        found = [nats(segment.prob) for segment in self._decoder.seg() or ()]
        return max(found, default=math.log(LEAST_PROBABILITY)) / self._phones
