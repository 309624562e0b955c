"""Generates the language files from a command list. Does I/O."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import msgspec
from msgspec.structs import replace

from voz.errors import LanguageError
from voz.files import atomic_write, sha256
from voz.language.command_source import CommandSource, read_list, similar_pairs
from voz.language.grammar import jsgf, structured_jsgf
from voz.language.language_files import (
    LanguageFiles,
    fingerprint,
    lock_folder,
    packaged_files,
    read_sentences,
)
from voz.language.ngram import arpa
from voz.language.pronunciation import (
    GUESSES,
    LexiconEntry,
    dictionary_entries,
    ipa_entries,
    read_cmudict,
)
from voz.language.sentences.command_set import encode_commands
from voz.language.sentences.text_lines import PRONUNCIATIONS_FILE, summarize_warnings
from voz.language.similarity_report import similarity_warnings
from voz.language.spoken_language import LanguageInfo
from voz.language.word_neighbors import (
    Rivals,
    encode_rivals,
    find_rivals,
    find_rivals_by_sound,
    read_common_words,
)


@dataclass(frozen=True)
class BuildResult:
    """What was built."""

    sentences: int  # how many sentences the language has
    words: int  # how many different words they have
    warnings: tuple[str, ...]  # what the user should know, one line each
    paths: tuple[Path, ...]  # the files written


def build(
    commands: Path,
    out: Path,
    source: CommandSource | None = None,
    every_pair: bool = False,
    before: Collection[str] = (),
) -> BuildResult:
    """Generate all language files from a command list, in a folder that is made if it is missing.

    A `pronunciations.txt` beside the list is used. `source` is what the list holds, if it was read
    before. It warns of the worst pairs that sound alike, or of every one, but of none whose
    sentences are in `before`.
    """
    source = source or read_list(commands)
    contents = _contents(source, out)
    _write(contents, out)
    sound_alike = _alike_warnings(source, every_pair, before)
    warnings = (*source.warnings, *_guess_warnings(source), *sound_alike)
    paths = tuple(out / name for name in contents)
    return BuildResult(len(source.commands), len(source.entries), warnings, paths)


def write_files(source: CommandSource, out: Path) -> None:
    """Write all language files of a list into a folder; raises LanguageError."""
    _write(_contents(source, out), out)


def stale_files(commands: Path, out: Path, source: CommandSource | None = None) -> list[str]:
    """Name the files in a folder that are missing or differ from what would be generated."""
    contents = _contents(source or read_list(commands), out)
    old = LanguageFiles(out).optional
    stale = [path.name for path in old if path.exists() and path.name not in contents]
    return [*(name for name, text in contents.items() if not _holds(out / name, text)), *stale]


def generate(
    sentences: Sequence[str],
    entries: Mapping[str, LexiconEntry],
    *,
    grammar: str | None = None,
    templates: str | None = None,
    spoken: str | None = None,
    plain_source: str | None = None,
    rivals: Rivals | None = None,
) -> dict[str, str]:
    """Generate the contents of all language files, by file name; deterministic, no I/O.

    Args:
        sentences: normalized, each once; a sample if there are very many.
        entries: the pronunciations of all their words, sorted by word.
        grammar: that of all sentences, where only a sample is given.
        templates: compiled templates as text; None for a plain list.
        spoken: the language as text; None for English.
        plain_source: where the list is as text, if it is plain and not beside the files.
        rivals: what sounds much like its words; None if that is not known.
    """
    files = LanguageFiles(Path())
    log = (f"{w}\t{e.origin}\t{way}" for w, e in entries.items() for way in e.ipa or e.phones)
    contents = {
        files.dictionary: _lines(_dictionary(entries)),
        files.lm: arpa(sentences),
        files.grammar: jsgf(sentences) if grammar is None else grammar,
        files.sentences: _lines([f"<s> {sentence} </s>" for sentence in sentences]),
        files.vocabulary: _lines(list(entries)),
        files.pronounce_log: _lines(list(log)),
    }
    if templates is not None:
        contents[files.templates] = templates
    if spoken is not None:
        contents[files.spoken] = spoken
    if ipa := [f"{word}\t{phones}" for word, phones in ipa_entries(entries)]:
        contents[files.ipa] = _lines(ipa)
    if plain_source is not None:
        contents[files.source] = plain_source
    if rivals is not None:
        contents[files.rival_words] = encode_rivals(rivals)
    named = {path.name: text for path, text in contents.items()}
    return {**named, files.fingerprint.name: fingerprint(named)}


def _contents(source: CommandSource, out: Path) -> dict[str, str]:
    spoken = _as_json(source.spoken, out) if source.spoken else None
    sources = {
        os.path.relpath(path.absolute(), out.absolute()): sha256(data).hexdigest()
        for path, data in source.files_read.items()
    }
    rivals = _rivals(source)
    if source.compiled is None:
        elsewhere = sources and LanguageFiles(out).commands.name not in sources
        where = f"{msgspec.json.encode(sources).decode()}\n" if elsewhere else None
        listed = source.commands.listed
        return generate(listed, source.entries, spoken=spoken, plain_source=where, rivals=rivals)
    commands, templates = source.commands, source.compiled.templates
    grammar = (
        None if commands.can_be_listed else structured_jsgf([one.expression for one in templates])
    )
    return generate(
        commands.examples(),
        source.entries,
        grammar=grammar,
        templates=encode_commands(commands, sources),
        spoken=spoken,
        rivals=rivals,
    )


def _rivals(source: CommandSource) -> Rivals | None:
    """The rivals of the words; None in a language whose common words are not known."""
    if source.spoken is None:
        said = {word: entry.phones for word, entry in source.entries.items()}
        return find_rivals(said, read_cmudict())
    common = read_common_words(source.spoken.code)
    heard = {word: entry.ipa for word, entry in source.entries.items() if entry.ipa}
    return find_rivals_by_sound(heard, common) if common and heard else None


def _as_json(spoken: LanguageInfo, out: Path) -> str:
    model = spoken.acoustic_model
    if model and not Path(model).is_absolute():  # the settings name it from the current folder
        model = os.path.relpath(Path(model).absolute(), out.absolute())
        spoken = replace(spoken, acoustic_model=model)
    return f"{msgspec.json.encode(spoken).decode()}\n"


def _dictionary(entries: Mapping[str, LexiconEntry]) -> list[str]:
    return [f"{word}\t{phones}" for word, phones in dictionary_entries(entries)]


def _lines(lines: Sequence[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except OSError:
        return False


def _guess_warnings(source: CommandSource) -> tuple[str, ...]:
    guessed = {word: entry for word, entry in source.entries.items() if entry.origin in GUESSES}
    each = [
        f'{source.places[word]}: "{word}" is in no dictionary; {" or ".join(entry.phones)} '
        f"is a guess: correct it in {PRONUNCIATIONS_FILE} beside the list"
        for word, entry in guessed.items()
    ]
    name = LanguageFiles(Path()).pronounce_log.name
    summary = (
        f"{source.name}: {len(each)} words are in no dictionary and their pronunciations are "
        f"guesses (see {name}): correct them in {PRONUNCIATIONS_FILE} beside the list"
    )
    return summarize_warnings(each, summary)


def _alike_warnings(source: CommandSource, every: bool, before: Collection[str]) -> tuple[str, ...]:
    # The user did not choose the sentences that come with voz.
    files = packaged_files(source.spoken.name if source.spoken else "")
    brought = set(read_sentences(files))
    return similarity_warnings(similar_pairs(source), every, [brought, before])


def _write(contents: Mapping[str, str], out: Path) -> None:
    """Write all files, or none: each is complete under another name before any is replaced.

    The fingerprint is replaced first: after an interruption it does not match the rest.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        with lock_folder(out, fcntl.LOCK_EX):
            with ExitStack() as last_first:
                for name, text in contents.items():
                    file = last_first.enter_context(atomic_write(out / name, "wb"))
                    file.write(text.encode())
                    file.flush()  # a full disk is noticed before any file is replaced
            for old in LanguageFiles(out).optional:
                if old.name not in contents:  # the list had templates before, or was in Spanish
                    old.unlink(missing_ok=True)
    except OSError as error:
        raise LanguageError(
            f"{out}: cannot be written ({error.strerror}); give a folder that you may write to"
        ) from None
