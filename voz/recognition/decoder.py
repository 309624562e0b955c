"""pocketsphinx, set up well: from the sound of an utterance to its sentence."""

from __future__ import annotations

from typing import Any

import pocketsphinx

from voz.audio import Samples
from voz.audio.denoise import frame_energies
from voz.errors import LanguageError
from voz.language.generated.fsg import to_fsg
from voz.recognition.accents import added
from voz.recognition.language import Language
from voz.settings import Search

CMN_START = (45.0, 3.0, -1.0)
"""Where the cepstral mean starts for speech of the usual level; further coefficients are 0.

A command is too short to estimate it from. Commands by synthetic foreign accents are right in .905
from pocketsphinx's own 40, .943 from 45 and .933 from 50; `stop` by people in .843, .867, .867.
"""

USUAL_LEVEL = 47.2
"""The mean energy of a command with its margins, in the recordings that the start is right for."""

LEVEL_WEIGHT = 0.66
"""How far the mean's first coefficient follows the level, for each dB.

It is 1.1 dB on average, and the words account for a part of the differences. Half of 210 commands
at 10 dB over kitchen noise are right with the fixed start, four of five with this.
"""

BEAMS = {"beam": 1e-80, "pbeam": 1e-80, "wbeam": 1e-60}
"""Of a long list: with pocketsphinx's own, 1e-48, one of 42 long sentences has no result, and
another is wrong. They take a sixth more time."""

PIECE = 800
"""Samples that are decoded at a time; no other thread of Python runs for those 3 ms."""


class Decoder:
    """Finds the sentence in a stretch of speech; made once, used for many."""

    def __init__(
        self, language: Language, search: Search = "grammar", mllr: str | None = None
    ) -> None:
        """Load the model.

        Args:
            language: whose commands it finds.
            search: "grammar" gives whole commands only, "lm" any sequence of their words.
            mllr: a file with the transform of the acoustic model for a speaker.

        Raises:
            LanguageError: pocketsphinx cannot use the language files.
        """
        # The lattice search that `bestpath` turns on loses a grammar's end, and with it the result.
        beams = {} if search == "lm" else BEAMS
        self._decoder = load_decoder(language, bestpath=search == "lm", mllr=mllr, **beams)
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
        """Find the sentence.

        Args:
            samples: one utterance, 16 kHz.
            start: where the cepstral mean starts, as `mean_start` gives it.

        Returns:
            Its words in lower case; empty if no sentence fits.
        """
        process(self._decoder, samples, start)
        hypothesis = self._decoder.hyp()
        return str(hypothesis.hypstr) if hypothesis else ""


def load_decoder(language: Language, **settings: Any) -> Any:
    """Load the acoustic model with the dictionary of a language, accents too, and no search yet.

    Args:
        language: whose commands it finds.
        settings: what differs from pocketsphinx's defaults.

    Raises:
        LanguageError: its files, or pocketsphinx's, cannot be used.
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
        for word, phones in added(language.dictionary, language.pronunciations).items():
            decoder.add_word(word, " ".join(phones), False)
    except (RuntimeError, ValueError) as error:
        raise LanguageError(_unusable(language.files.dictionary)) from error
    return decoder


def _unusable(path: object) -> str:
    return f"{path}: cannot be used; make the language files again with `voz build-lm`"


def mean_start(samples: Samples) -> str:
    """Tell where the cepstral mean starts for an utterance: it hangs on the level, and so on noise.

    Args:
        samples: the utterance with its margins, 16 kHz.

    Returns:
        The mean's coefficients as pocketsphinx reads them.
    """
    found = frame_energies(samples)
    louder = float(found.mean()) - USUAL_LEVEL if len(found) else 0.0
    first, *others = CMN_START
    return ",".join(f"{value:.2f}" for value in (first + LEVEL_WEIGHT * louder, *others))


def process(decoder: Any, samples: Samples, start: str) -> None:
    """Decode one utterance, with nothing left in the front end of the one before.

    `reinit_feat` and `set_cmn` make a used decoder equal to a fresh one. The mean then follows the
    utterance as it would live: the mean of a whole short utterance (`full_utt`) is worse.
    """
    decoder.reinit_feat()
    decoder.set_cmn(start)
    decoder.start_utt()
    for at in range(0, len(samples), PIECE):
        decoder.process_raw(samples[at : at + PIECE].tobytes())
    decoder.end_utt()
