"""pocketsphinx, set up well: from the sound of an utterance to its sentence."""

from __future__ import annotations

from typing import Any

import pocketsphinx

from voz.audio import Samples
from voz.config import Search
from voz.errors import LanguageError
from voz.language.files import LanguageFiles

CMN_START = "45,3,-1"
"""Where the cepstral mean starts.

A command is too short to estimate it from. Commands by synthetic foreign accents are right in .905
from pocketsphinx's own 40, .943 from 45 and .933 from 50; `stop` by people in .843, .867, .867.
"""

ACOUSTIC_MODEL = "en-us/en-us"


class Decoder:
    """Finds the sentence in a stretch of speech; made once, used for many."""

    def __init__(self, language: LanguageFiles, search: Search = "grammar") -> None:
        """Load the model.

        Args:
            language: the dictionary, and the grammar or the trigram model.
            search: "grammar" gives whole commands only, "lm" any sequence of their words.

        Raises:
            LanguageError: pocketsphinx cannot use the language files.
        """
        # The lattice search that `bestpath` turns on loses a grammar's end, and with it the result.
        self._decoder = load_decoder(language, bestpath=search == "lm")
        source = language.lm if search == "lm" else language.grammar
        add = self._decoder.add_lm_file if search == "lm" else self._decoder.add_jsgf_file
        try:
            add("commands", str(source))
            self._decoder.activate_search("commands")
        except (RuntimeError, ValueError, KeyError) as error:
            raise LanguageError(_unusable(source)) from error

    def decode(self, samples: Samples) -> str:
        """Find the sentence.

        Args:
            samples: one utterance, 16 kHz.

        Returns:
            Its words in lower case; empty if no sentence fits.
        """
        process(self._decoder, samples)
        hypothesis = self._decoder.hyp()
        return str(hypothesis.hypstr) if hypothesis else ""


def load_decoder(language: LanguageFiles, **settings: Any) -> Any:
    """Load the acoustic model with the dictionary of a language and no search yet.

    Args:
        language: the language files.
        settings: what differs from pocketsphinx's defaults.

    Raises:
        LanguageError: pocketsphinx cannot use the dictionary.
    """
    if not language.dictionary.is_file():
        raise LanguageError(_unusable(language.dictionary))
    config = pocketsphinx.Config(
        hmm=pocketsphinx.get_model_path(ACOUSTIC_MODEL),
        dict=str(language.dictionary),
        lm=None,
        loglevel="FATAL",  # its own messages are about its insides; ours say what to do
        **settings,
    )
    try:
        return pocketsphinx.Decoder(config)
    except (RuntimeError, ValueError) as error:
        raise LanguageError(_unusable(language.dictionary)) from error


def _unusable(path: object) -> str:
    return f"{path}: cannot be used; make the language files again with `voz build-lm`"


def process(decoder: Any, samples: Samples) -> None:
    """Decode one utterance, with nothing left in the front end of the one before.

    `reinit_feat` and `set_cmn` make a used decoder equal to a fresh one. The mean then follows the
    utterance as it would live: the mean of a whole short utterance (`full_utt`) is worse.
    """
    decoder.reinit_feat()
    decoder.set_cmn(CMN_START)
    decoder.start_utt()
    if len(samples):  # pocketsphinx refuses nothing at all
        decoder.process_raw(samples.tobytes())
    decoder.end_utt()
