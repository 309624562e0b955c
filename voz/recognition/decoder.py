"""pocketsphinx, set up well: the sentence that was said, and how well it explains the sound."""

from __future__ import annotations

import math
from pathlib import Path
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

FILLERS = Path(__file__).with_name("phone_loop.fillers")
"""The phones of the acoustic model as words of their own; no command has an underscore."""

SILENCE_WEIGHT = 0.005
"""pocketsphinx's own `silprob`, which it uses for the silences that it adds itself."""

UNPRUNED = 1e-300
"""A beam so wide that a sentence much worse than the phone loop is still scored."""

SCORE_UNIT = 1024 * math.log(1.0001)
"""pocketsphinx counts acoustic scores in 1.0001-logarithms shifted right by 10 bits; this in nats.

`logmath.h` has the base, `SENSCR_SHIFT` in `hmm.h` the shift.
"""


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
        self._decoder = _load(language, bestpath=search == "lm")
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
        _process(self._decoder, samples)
        hypothesis = self._decoder.hyp()
        return str(hypothesis.hypstr) if hypothesis else ""


class PhoneLoop:
    """Tells how much better or worse a sentence explains the sound than any sequence of phones.

    The sentence and a free loop of phones are searched together, so that both are scored against
    the same best state of each frame, and the two results are read one after the other. Two
    searches with `compallsen`, which makes separate scores comparable, tell commands from other
    speech no better and take four times as long.
    """

    def __init__(self, language: LanguageFiles) -> None:
        """Load the model; raises LanguageError as `Decoder` does."""
        # As fillers the phones keep their context-independent models: a third of the time.
        # The search then must not put them everywhere; the silences are in its arcs.
        self._decoder = _load(
            language,
            bestpath=False,
            fdict=str(FILLERS),
            fsgusefiller=False,
            ds=2,  # every other frame's Gaussians in full: 0.6 of the time
            beam=UNPRUNED,
            pbeam=UNPRUNED,
            wbeam=UNPRUNED,
        )
        lines = FILLERS.read_text(encoding="ascii").splitlines()
        self._phones = [line.split()[0] for line in lines if line.startswith("_")]

    def ratio(self, samples: Samples, text: str) -> float:
        """Compare a sentence with the phone loop.

        Args:
            samples: one utterance, 16 kHz.
            text: the sentence; its words are in the dictionary.

        Returns:
            The log-likelihood ratio of the two for each frame of speech, in nats: around 0 and
            more for this sentence, far below 0 for something else; -inf if one has no path.
        """
        words = text.split()
        sentence_end, loop = len(words), len(words) + 1
        search = self._search_for(words, loop)
        _process(self._decoder, samples)
        search.set_final_state(sentence_end)
        sentence = self._decoder.hyp()
        search.set_final_state(loop)
        phones = self._decoder.hyp()
        if sentence is None or phones is None:
            return -math.inf
        frames = sum(
            segment.end_frame - segment.start_frame + 1
            for segment in self._decoder.seg()
            if segment.word in self._phones
        )
        return float((_nats(sentence.score) - _nats(phones.score)) / max(frames, 1))

    def _search_for(self, words: list[str], loop: int) -> Any:
        """A chain of states for the words, and beside it one state with a loop for each phone."""
        arcs: list[tuple[Any, ...]] = [(at, at + 1, 1.0, word) for at, word in enumerate(words)]
        arcs += [(state, state, SILENCE_WEIGHT, "<sil>") for state in range(loop + 1)]
        arcs.append((0, loop, 1.0))
        arcs += [(loop, loop, 1 / len(self._phones), phone) for phone in self._phones]
        # Made anew for each utterance: it takes less than a millisecond, and a list of thousands
        # of commands would keep thousands.
        self._decoder.add_fsg("ratio", self._decoder.create_fsg("ratio", 0, len(words), arcs))
        self._decoder.activate_search("ratio")
        return self._decoder.get_fsg("ratio")


def _load(language: LanguageFiles, **settings: Any) -> Any:
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


def _process(decoder: Any, samples: Samples) -> None:
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


def _nats(score: float) -> float:
    """Back from `logmath.exp(score)`, which is how pocketsphinx's Python hands scores out."""
    return math.log(score) / math.log(1.0001) * SCORE_UNIT
