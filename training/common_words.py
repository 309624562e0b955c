"""Makes the files of `voz/language/common_words`: how the commonest words of languages are said.

    python training/common_words.py

The words are those of PyPI's `wordfreq` (https://doi.org/10.5281/zenodo.7199437, its data CC BY-SA
4.0), the pronunciations espeak-ng's. Each stands once, without the words that are said so.
"""

from __future__ import annotations

import gzip

from wordfreq import top_n_list

from voz.language.espeak import accents_of, written_by_espeak
from voz.language.phones import known_phones, parse_phones
from voz.language.spoken_language import ENGLISH_NAMES, known_languages
from voz.language.word_neighbors import COMMON_WORDS, MIN_PHONES

WORDS = 20_000
"""So many of each language."""


def main() -> None:
    """Write a file for each language that voz knows."""
    for language in {known.code for known in known_languages()} - ENGLISH_NAMES:
        words = [word for word in top_n_list(language, WORDS) if word.isalpha() and len(word) > 1]
        written = (line for each in accents_of(language) for line in written_by_espeak(words, each))
        said = {" ".join(way) for line in written if is_long(way := parse_phones(line))}
        text = "".join(f"{way}\n" for way in sorted(said))
        path = COMMON_WORDS / f"{language}.gz"
        path.write_bytes(gzip.compress(text.encode(), mtime=0))
        print(f"{path}: {len(said)} pronunciations")


def is_long(way: tuple[str, ...]) -> bool:
    """Whether a word may be the rival of one that is long enough to have rivals."""
    return len(way) >= MIN_PHONES - 1 and known_phones().issuperset(way)


if __name__ == "__main__":
    main()
