"""Commands in another language, by a model whose phones are others."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import soundfile
import soxr
from calls import in_process
from recordings import ROOT, read_manifest
from spanish import RULES, spanish

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.config import load_config
from voz.control.table import DEFAULT_STATE
from voz.errors import ConfigError
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.language_files import LanguageFiles, packaged_files
from voz.language.spoken_language import configured_language, find_sources, read_language
from voz.recognition.confidence import load_models
from voz.recognition.language import Language, load_language, with_more_words
from voz.recognition.network.phoneme_network import UnknownNetworkError
from voz.recognition.network.score import scorer_for, why_missing
from voz.settings import Recognition, SpokenLanguage
from voz.speech.synthesis import render

EXAMPLE = ROOT / "examples" / "spanish"


def by_a_model(folder: Path, name: str) -> LanguageFiles:
    """The list of the example, with a model made for this."""
    spanish(folder / "es")
    settings = SpokenLanguage(
        name=name,
        acoustic_model=str(folder / "es/model_parameters/es"),
        dictionary=str(folder / "es/es.dic"),
        pronunciations=str(RULES),
    )
    sources = find_sources(settings)
    assert sources
    commands = EXAMPLE / "comandos.txt"
    build(commands, folder / "lm", read_list(commands, read_language(sources)))
    return LanguageFiles(folder / "lm")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> LanguageFiles:
    return by_a_model(tmp_path_factory.mktemp("spanish"), "es")


@pytest.fixture(scope="module")
def in_spanish(files: LanguageFiles) -> Language:
    return load_language(files)


def said(text: str, folder: Path, language: str = "es") -> Samples:
    """A text in another language, with a quiet room around it."""
    render(text, f"espeak-ng:{language}", folder / "said.wav")
    sound, rate = soundfile.read(folder / "said.wav", dtype="float32")
    whole = np.pad(soxr.resample(sound, rate, 16000) * 0.5, 8000)
    room = np.random.default_rng(0).normal(0, 3e-4, len(whole))
    return ((whole + room) * 32767).astype(np.int16)


@pytest.mark.slow
def test_commands_in_spanish_are_understood(files: LanguageFiles, tmp_path: Path) -> None:
    recognizer = Recognizer(files, Recognition(never_missed=("para",)))
    for text in ("para", "avanza", "más despacio", "señala la cocacola", "gira a la derecha"):
        (heard,) = recognizer.utterances([said(text, tmp_path)], "")
        assert (heard.text, heard.accepted) == (text, True)
        assert heard.score is not None  # the network decided


@pytest.mark.slow
@pytest.mark.parametrize("accent", ["es", "es-419"])
def test_a_command_with_another_common_word_in_it_is_refused(tmp_path: Path, accent: str) -> None:
    commands = tmp_path / "commands.txt"
    commands.write_text("coge la caja\nabre la puerta\navanza\n", encoding="utf-8")
    spoken = configured_language(SpokenLanguage(name="es"))
    build(commands, tmp_path / "lm", read_list(commands, spoken))
    recognizer = Recognizer(LanguageFiles(tmp_path / "lm"), Recognition())
    heard = {}
    for text in ("coge la caja", "coge la casa", "abre la puerta", "abre la huerta"):
        (found,) = recognizer.utterances([said(text, tmp_path, accent)], "")
        heard[text] = (found.text, found.accepted)
    assert heard == {
        "coge la caja": ("coge la caja", True),
        "coge la casa": ("coge la caja", False),
        "abre la puerta": ("abre la puerta", True),
        "abre la huerta": ("abre la puerta", False),
    }


@pytest.mark.slow
def test_pocketsphinx_decides_alone_by_a_model_of_a_language_with_another_name(
    tmp_path: Path,
) -> None:
    files = by_a_model(tmp_path, "castellano")
    assert why_missing(files) == "it does not know the phones of castellano"
    recognizer = Recognizer(files, Recognition(never_missed=("para",)))
    (heard,) = recognizer.utterances([said("avanza", tmp_path)], "")
    assert (heard.text, heard.accepted, heard.score) == ("avanza", True, None)


@pytest.mark.slow
def test_the_confidence_is_fitted_where_pocketsphinx_decides_alone(tmp_path: Path) -> None:
    files = by_a_model(tmp_path, "castellano")
    near = [r for r in read_manifest() if r.kind == "near-miss"]
    rows = [(r.path, r.text, r.voice, r.kind) for r in near[::4]]
    rows += [(r.path, r.text, r.voice, "talk") for r in near[1::2]]
    for text in ("para", "avanza", "más despacio", "gira a la derecha"):
        path = tmp_path / f"{text}.wav"
        soundfile.write(path, said(text, tmp_path), SAMPLE_RATE)
        rows.append((path, text, f"who says {text}", "command"))
    lines = ["\t".join(map(str, row)) for row in (("path", "text", "speaker", "kind"), *rows)]
    (tmp_path / "list.tsv").write_text("\n".join(lines), encoding="utf-8")
    out = tmp_path / "mine.json"
    given = ("fit-confidence", tmp_path / "list.tsv", "--lm", files.folder, "--out", out)
    result = in_process(*given)
    assert (result.code, result.err) == (0, "")
    fitted, now = load_models(str(out)), load_models()
    assert fitted.with_network == now.with_network
    assert fitted.without_network != now.without_network


def test_nothing_of_english_is_added(in_spanish: Language) -> None:
    assert in_spanish.pronunciations == in_spanish.dictionary


def test_the_network_steps_aside_by_the_language_and_not_by_the_names_of_phones(
    loaded: Language,
) -> None:
    scorer_for(loaded)
    spoken = loaded.spoken
    same_phones = type(spoken)("es", spoken.acoustic_model, "", spoken.frames, spoken.apart)
    with pytest.raises(UnknownNetworkError, match="does not know the phones of es"):
        scorer_for(dataclasses.replace(loaded, spoken=same_phones))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("language", "commands", "others"),
    [
        ("es", ("para", "avanza", "gira a la izquierda"), ("buenos días", "qué hora es")),
        ("fr", ("arrête toi", "tourne à gauche"), ("il fait beau", "bonjour à tous")),
    ],
)
def test_the_network_decides_where_espeak_ng_pronounces(
    language: str, commands: tuple[str, ...], others: tuple[str, ...], tmp_path: Path
) -> None:
    listed = tmp_path / "list.txt"
    listed.write_text("\n".join(commands), encoding="utf-8")
    spoken = configured_language(SpokenLanguage(name=language))
    build(listed, tmp_path / "lm", read_list(listed, spoken))
    files = LanguageFiles(tmp_path / "lm")
    assert why_missing(files) is None
    recognizer = Recognizer(files, Recognition(never_missed=commands[:1]))
    for text in commands:
        (heard,) = recognizer.utterances([said(text, tmp_path, language)], "")
        assert (heard.text, heard.accepted) == (text, True)
        assert heard.score is not None
    for text in others:
        heard = list(recognizer.utterances([said(text, tmp_path, language)], ""))
        assert not any(utterance.accepted for utterance in heard)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("other", "may_be_left_out"),
    [
        ("tourne à droite", True),
        ("à", False),
        ("tourne gauche", False),
        ("avance de {meters: 1..21}", False),
    ],
)
def test_a_word_of_one_vowel_may_be_left_out_unless_that_is_another_command(
    other: str, may_be_left_out: bool, tmp_path: Path
) -> None:
    text = "tourne à gauche"
    (tmp_path / "list.txt").write_text(f"{text}\n{other}", encoding="utf-8")
    spoken = configured_language(SpokenLanguage(name="fr"))
    build(tmp_path / "list.txt", tmp_path / "lm", read_list(tmp_path / "list.txt", spoken))
    scorer = scorer_for(load_language(LanguageFiles(tmp_path / "lm")))
    whole, quick = (
        scorer.rank(scorer.phone_likelihoods(said(heard, tmp_path, "fr")), [text]).score
        for heard in (text, "tourne gauche")
    )
    assert (whole - quick < 6) == may_be_left_out


@pytest.mark.slow
def test_a_name_is_heard_by_the_nearest_english_phones(tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("avanza\npara\nllama al robot\n", encoding="utf-8")
    language = configured_language(SpokenLanguage(name="es"))
    build(tmp_path / "list.txt", tmp_path / "lm", read_list(tmp_path / "list.txt", language))
    files = LanguageFiles(tmp_path / "lm")
    settings = Recognition(name="oye robot", never_missed=("para",))
    named = with_more_words(load_language(files), settings)
    assert named.ipa["oye"] == named.pronunciations["oye"] == ("OW", "Y", "EH")
    assert named.ipa["robot"] == ("R", "OW", "V", "OW", "T")  # a word of the list, too
    assert named.ipa["avanza"] == ("a", "β", "a", "n", "θ", "a")
    recognizer = Recognizer(files, settings)
    for text, heard_text, is_named in (
        ("oye robot", "oye robot", True),
        ("oye robot, avanza", "avanza", True),
        ("avanza", "avanza", False),
    ):
        (heard,) = recognizer.utterances([said(text, tmp_path)], "")
        assert (heard.text, heard.accepted, heard.named) == (heard_text, True, is_named)


def test_questions_are_answered_in_a_language_that_has_texts(
    files: LanguageFiles, tmp_path: Path
) -> None:
    asking = Recognition(ask="always")
    answers = with_more_words(load_language(packaged_files("es")), asking)
    assert answers.ipa["sí"] == ("s", "i")
    assert answers.pronunciations["no"] == ("N", "OW")
    (tmp_path / "list.txt").write_text("avanti\n")
    italian = configured_language(SpokenLanguage(name="it"))
    build(tmp_path / "list.txt", tmp_path / "lm", read_list(tmp_path / "list.txt", italian))
    with pytest.raises(ConfigError, match="voz asks nothing in it"):
        with_more_words(load_language(LanguageFiles(tmp_path / "lm")), asking)
    with pytest.raises(ConfigError, match="own, as that of es"):
        with_more_words(load_language(files), Recognition(name="oye robot"))


def test_phones_without_symbols_are_split_or_become_english_ones(tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("pizza\nokay\n", encoding="utf-8")
    (tmp_path / "pronunciations.txt").write_text("pizza p i ts a\nokay oʊ K eɪ\n")  # noqa: RUF001
    language = configured_language(SpokenLanguage(name="it"))
    build(tmp_path / "list.txt", tmp_path / "lm", read_list(tmp_path / "list.txt", language))
    loaded = load_language(LanguageFiles(tmp_path / "lm"))
    assert loaded.dictionary["pizza"] == ("P", "IY", "T", "S", "AA")
    assert loaded.ipa["pizza"] == ("p", "i", "ts", "a")
    assert loaded.dictionary["okay"] == ("OW", "K", "EY")
    network = scorer_for(loaded)
    assert (network.count_phones("pizza"), network.count_phones("okay")) == (5, 3)


def test_the_settings_of_the_example_are_whole() -> None:
    settings = load_config(EXAMPLE / "voz.toml")
    listed = (EXAMPLE / "comandos.txt").read_text(encoding="utf-8").splitlines()
    known = set(settings.table.sets[DEFAULT_STATE])
    assert {line for line in listed if not line.startswith("#")} <= known
    assert settings.table.stops == {"stop", "para"}
    assert settings.speech.voice == "espeak-ng:es"
