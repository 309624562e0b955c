"""Words and phrases by synthetic voices, to learn from.

    python training/synthesize.py OUT

Voices of other languages read English respelled in their letters, which is near to what a heavy
accent makes of it. Needs festival, flite, espeak-ng and PyPI's `py-nanotts`; voices that are not
installed are left out.
"""

from __future__ import annotations

import csv
import random
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import numpy as np
import soundfile
import soxr
import typer

from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.errors import SpeechError
from voz.language.pronunciation import find_anywhere, look_up, read_cmudict
from voz.language.word_neighbors import word_log_probability

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

from synthesis import Voice, synthesize

RESPELLING = Path(__file__).with_name("respelling.tsv")


def _pico(language: str) -> Voice:
    return Voice((sys.executable, str(Path(__file__).with_name("pico.py")), language))


ENGLISH = {
    **{f"flite-{name}": Voice.flite(name) for name in ("kal16", "awb", "rms", "slt")},
    **{
        f"festival-{name}": Voice.festival(name)
        for name in ("kal_diphone", "ked_diphone", "cmu_us_slt_arctic_hts")
    },
    **{f"pico-{language}": _pico(language) for language in ("en-US", "en-GB")},
    **{
        f"espeak-{language}-{variant}": Voice.espeak(f"{language}+{variant}")
        for language in ("en-us", "en-gb", "en-gb-scotland", "en-029", "en-gb-x-rp")
        for variant in ("m1", "m3", "m7", "f1", "f3", "f5")
    },
}

FOREIGN = {
    **{
        f"espeak-{language}-{variant}": (language, Voice.espeak(f"{language}+{variant}"))
        for language in ("de", "es", "it", "fr", "id", "nl", "pl", "pt-br", "ru", "tr")
        for variant in ("m1", "m2", "m4", "f2", "f4")
    },
    "festival-lp_diphone": ("it", Voice.festival("lp_diphone")),
    "festival-pc_diphone": ("it", Voice.festival("pc_diphone")),
    **{
        f"festival-czech_{name}": ("es", Voice.festival(f"czech_{name}"))
        for name in ("ph", "dita", "krb", "machac")
    },
    "festival-hy_fi_mv_diphone": ("es", Voice.festival("hy_fi_mv_diphone")),
    "festival-suo_fi_lj_diphone": ("es", Voice.festival("suo_fi_lj_diphone")),
    "festival-upc_ca_ona_hts": ("es", Voice.festival("upc_ca_ona_hts")),
    "festival-russian": ("ru", Voice.festival("msu_ru_nsh_clunits")),
    "festival-hindi": ("hi", Voice.festival("hindi_NSK_diphone")),
    "pico-de": ("de", _pico("de-DE")),
    "pico-es": ("es", _pico("es-ES")),
    "pico-fr": ("fr", _pico("fr-FR")),
    "pico-it": ("it", _pico("it-IT")),
}
"""Each with the column of `RESPELLING` by which it reads English."""

KINDS = (
    [name for name in ENGLISH if not name.startswith("espeak")],
    [name for name in ENGLISH if name.startswith("espeak")],
    [name for name in FOREIGN if not name.startswith("espeak")],
    [name for name in FOREIGN if name.startswith("espeak")],
)
"""Voices that are drawn from alike often."""

DEVANAGARI_CONSONANTS = frozenset("कखगघङचछजझञटठडढणतथदधनपफबभमयरलवशषसह़")

DEVANAGARI_SIGNS = dict(zip("अआइईउऊएऐओऔऑऍ", ["", *"ािीुूेैोौॉॅ"], strict=True))
"""What a vowel is written as after a consonant."""

NO_VOWEL = "्"

SINGLE = 0.6
"""How many of the clips are one word; the others are two to four."""


def main(
    out: Annotated[Path, typer.Argument(help="Folder of the recordings and their manifest.tsv.")],
    words: Annotated[int, typer.Option(min=1, help="Of how many of the commonest words.")] = 3000,
    clips: Annotated[int, typer.Option(min=1, help="How many recordings.")] = 8000,
    seed: Annotated[int, typer.Option(help="Of the choice of words and voices.")] = 1,
) -> None:
    """Have voices read words and short phrases.

    Example: python training/synthesize.py words --clips 2000
    """
    (out / "clips").mkdir(parents=True, exist_ok=True)
    known = common_words(words)
    rng = random.Random(seed)
    spellings = spellings_of_phones()
    missing: set[str] = set()
    heard: set[str] = set()
    rows = []
    for number in with_bar(range(clips), "Synthesizing"):
        many = 1 if rng.random() < SINGLE else rng.randint(2, 4)
        text = rng.sample([*known], many)
        voice = rng.choice(rng.choice(KINDS))
        phones = " ".join(known[word] for word in text)
        path = out / "clips" / f"{number:05}.flac"
        if voice in missing:
            continue
        try:
            seconds = _speak(voice, text, known, spellings, path)
        except SpeechError:
            if voice not in heard:
                missing.add(voice)
            continue
        heard.add(voice)
        rows.append((path.relative_to(out), " ".join(text), phones, voice, f"{seconds:.2f}"))
    with (out / "manifest.tsv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", "text", "phones", "speaker", "seconds"))
        table.writerows(rows)
    if missing:
        typer.echo(f"left out, as they are not installed: {', '.join(sorted(missing))}", err=True)


def common_words(number: int) -> dict[str, str]:
    """The commonest words of pocketsphinx's language model, with their usual phones."""
    cmudict = read_cmudict()
    names = {line.split(b" ", 1)[0].decode() for line in cmudict.splitlines()}
    plain = sorted(name for name in names if name.isalpha() and (len(name) > 1 or name in "ai"))
    plain.sort(key=word_log_probability(), reverse=True)
    return usual_phones(plain[:number])


def usual_phones(words: Iterable[str]) -> dict[str, str]:
    """The usual phones of those words that the dictionary has."""
    cmudict = read_cmudict()
    found = {word: look_up(cmudict, word) or find_anywhere(cmudict, word) for word in words}
    return {word: phones[0] for word, phones in found.items() if phones}


def _speak(
    name: str,
    text: list[str],
    known: dict[str, str],
    spellings: dict[str, dict[str, str]],
    path: Path,
) -> float:
    """Write a recording; returns its length, s."""
    if name in ENGLISH:
        sound, rate = synthesize(ENGLISH[name], f"{' '.join(text)}.\n")
    else:
        language, voice = FOREIGN[name]
        letters = spellings[language]
        spelled = [joined([letters[phone] for phone in known[word].split()]) for word in text]
        sound, rate = synthesize(voice, f"{' '.join(spelled)}.\n")
    mono = sound.reshape(len(sound), -1)[:, 0]
    peak = np.abs(mono).max()
    if peak == 0:
        raise SpeechError(f"{name}: says nothing for {text}")
    resampled = soxr.resample(mono * (0.5 / peak), rate, SAMPLE_RATE)
    soundfile.write(path, resampled, SAMPLE_RATE, subtype="PCM_16")
    return len(resampled) / SAMPLE_RATE


def joined(letters: list[str]) -> str:
    """A word of its letters; in Devanagari signs join a vowel, or none, to a consonant."""
    word = ""
    for letter in letters:
        after_consonant = bool(word) and word[-1] in DEVANAGARI_CONSONANTS
        if after_consonant and letter[0] in DEVANAGARI_SIGNS:
            word += DEVANAGARI_SIGNS[letter[0]] + letter[1:]
        elif after_consonant and letter[0] in DEVANAGARI_CONSONANTS:
            word += NO_VOWEL + letter
        else:
            word += letter
    return word


def spellings_of_phones() -> dict[str, dict[str, str]]:
    """The letters of each phone, by language."""
    with RESPELLING.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    languages = [column for column in rows[0] if column != "phone"]
    return {each: {row["phone"]: row[each] for row in rows} for each in languages}


if __name__ == "__main__":
    typer.run(main)
