"""README and docs/ are right: links, command lines, settings, code; no network is needed."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path
from typing import Any

import msgspec
import pytest
import typer
from calls import in_process
from documents import (
    Document,
    anchors,
    broken_links,
    commands_named,
    commands_shown,
    generated,
    written,
)
from language.template_texts import commands_of
from make_reference import API, SAMPLES
from recordings import ROOT

import voz
from voz.cli.subcommands import UsageError, app
from voz.config import Config, load_config
from voz.events import Event, to_json
from voz.language.language_files import packaged_files, read_sentences

each_page = pytest.mark.parametrize("page", written(), ids=lambda page: str(page.path))
COMMANDS = typer.main.get_command(app)


def refusal(call: str, whole: bool = True) -> str | None:
    """Why the command line would refuse a call; None if it takes it."""
    name, *arguments = shlex.split(call)[1:]
    if name.startswith("-"):
        known = {option for each in COMMANDS.params for option in each.opts} | {"--help", "-h"}
        return None if name in known else f"no option {name}"
    if name not in COMMANDS.commands:  # type: ignore[attr-defined]
        return f"no subcommand {name}"
    command = COMMANDS.commands[name]  # type: ignore[attr-defined]
    try:
        command.make_context(name, [a for a in arguments if a != "--help"])
    except UsageError as error:
        left_out = type(error).__name__ == "MissingParameter" and not whole
        return None if left_out else str(error.format_message())
    return None


@each_page
def test_each_link_leads_somewhere(page: Document) -> None:
    pages = {each.path: each.text for each in (*written(), *generated())}
    assert list(broken_links(page, pages)) == []


def test_each_link_of_the_reference_leads_somewhere() -> None:
    pages = {each.path: each.text for each in (*written(), *generated())}
    assert [broken for page in generated() for broken in broken_links(page, pages)] == []


def test_a_link_that_leads_nowhere_is_found() -> None:
    page = Document(
        Path("docs/a.md"),
        "[a](b.md) [b](start.md#no) [c](start.md) [d](#here) [e](#a.B)\n# Here\n::: a.B\n"
        '<img src="no.png">',
    )
    pages = {each.path: each.text for each in written()} | {page.path: page.text}
    assert list(broken_links(page, pages)) == [
        "docs/a.md: b.md: there is no such file",
        "docs/a.md: start.md#no: there is no such heading",
        "docs/a.md: no.png: there is no such file",
    ]


@each_page
def test_each_call_of_voz_is_one_that_it_takes(page: Document) -> None:
    refused = {call: refusal(call) for call in commands_shown(page)}
    refused |= {call: refusal(call, whole=False) for call in commands_named(page)}
    assert {call: why for call, why in refused.items() if why} == {}


@pytest.mark.parametrize("call", ["voz runs", "voz run --wave a.wav", "voz decode", "voz --what"])
def test_a_call_that_voz_does_not_take_is_found(call: str) -> None:
    assert refusal(call)


def test_calls_are_found_in_blocks_and_in_text() -> None:
    page = Document(
        Path("a.md"), "say `voz run\n--text -`\n```\n$ voz say hello  # loud\nhello\n```\n"
    )
    assert list(commands_shown(page)) == ["voz say hello "]
    assert list(commands_named(page)) == ["voz run --text -"]


@each_page
def test_each_setting_that_is_shown_can_be_set(page: Document, tmp_path: Path) -> None:
    for number, block in enumerate(page.blocks("toml")):
        path = tmp_path / f"{number}.toml"
        path.write_text(block, encoding="utf-8")
        load_config(path)


@each_page
def test_each_python_that_is_shown_compiles(page: Document) -> None:
    for block in page.blocks("python"):
        compile(block, str(page.path), "exec", dont_inherit=True)


@each_page
def test_no_code_has_a_bar_that_is_shown_with_its_backslash(page: Document) -> None:
    # GitHub needs the backslash in a table and leaves it out; mkdocs shows it.
    assert not re.search(r"`[^`\n]*\\\|", page.text)


def test_the_notation_of_sentences_means_what_is_said_beside_it() -> None:
    text = (ROOT / "docs" / "sentences.md").read_text(encoding="utf-8")
    block = text.split("## The notation\n\n```\n")[1].split("```")[0].replace("import ", "# ")
    commands = commands_of(block)
    said = [one for line in block.splitlines() for one in re.findall(r'"([^"]{3,})"', line)]
    assert len(said) > 10
    assert [one for one in said if not commands.parse(one)] == []
    for typed, name, slots in (
        ("bring the deep blue cup", "bring the {color} cup", {"color": "blue"}),
        ("go one and a half metres", "go {far} metres", {"far": 1.5}),
        ("from the table to the shelf", "from {origin} to {goal}", None),
        ("move on", "go on", {}),
    ):
        parse = commands.parse(typed)
        assert parse
        assert parse.command == name
        assert slots is None or parse.slots == slots


def test_all_settings_are_shown_and_explained() -> None:
    shown = (ROOT / "docs" / "settings.md").read_text(encoding="utf-8")
    (reference,) = (page.text for page in generated() if page.path.name == "settings.md")
    for table in (Config, *(f.type for f in msgspec.structs.fields(Config))):
        for field in getattr(table, "__struct_fields__", ()):
            assert re.search(rf"^(# )?\[?{field}\b", shown, re.M), field
            if table is not Config or not hasattr(getattr(Config(), field), "__struct_fields__"):
                assert f"| `{field}` |" in reference


def test_each_event_is_shown_as_it_is_written() -> None:
    (reference,) = (page.text for page in generated() if page.path.name == "events.md")
    for kind in Event.__args__:
        assert any(isinstance(event, kind) for event in SAMPLES)
    assert all(to_json(event) in reference for event in SAMPLES)


def test_all_that_voz_offers_is_in_the_reference() -> None:
    (reference,) = (page.text for page in generated() if page.path.name == "api.md")
    told = {*re.findall(r"^::: voz\.(\w+)$", reference, re.M)}
    assert told | {"Event", "__version__"} == set(voz.__all__)
    assert {name for names in API.values() for name in names} <= told


def test_all_subcommands_are_in_the_reference() -> None:
    (reference,) = (page.text for page in generated() if page.path.name == "command-line.md")
    assert set(COMMANDS.commands) <= anchors_of_commands(reference)  # type: ignore[attr-defined]


def anchors_of_commands(reference: str) -> set[str]:
    return {anchor.removeprefix("voz-") for anchor in anchors(reference)}


def test_each_page_can_be_found_from_the_first_one() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert "](docs/index.md)" in (ROOT / "README.md").read_text(encoding="utf-8")
    for page in written():
        if page.path.parent == Path("docs") and page.path.name != "index.md":
            assert f" {page.path.name}\n" in navigation
            assert f"]({page.path.name})" in index


def test_the_guide_is_in_groups_that_are_seen_at_once() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    guide = navigation.partition("  - Guide:\n")[2].partition("\n  - ")[0]
    groups = re.split(r"^ {6}- (.+):\n", guide, flags=re.MULTILINE)[1:]
    headings = re.findall(r"^## (.+)$", (ROOT / "docs" / "index.md").read_text("utf-8"), re.M)
    assert groups[::2] == headings[:5]
    assert all(4 <= len(pages.splitlines()) <= 7 for pages in groups[1::2])


def test_the_site_has_the_logo_of_the_operator_page() -> None:
    icon = ROOT / "voz" / "apps" / "web" / "page" / "icon.svg"
    assert (ROOT / "docs" / "logo.svg").read_bytes() == icon.read_bytes()


def test_each_thread_is_told_of_with_its_queue() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "voz").rglob("*.py"))
    names = set(re.findall(r'(?:name=|\()"(voz-[a-z-]+)", (?:lambda|daemon)', code))
    assert {"voz-hearing", "voz-pace"} <= names
    assert {name for name in names if f"\n| `{name}`" not in page} == set()


def test_who_uninstalls_is_told_each_folder_that_voz_makes() -> None:
    page = (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
    code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "voz").rglob("*.py"))
    kinds = set(re.findall(r'data_folder\("(\w+)"\)', code))
    (named,) = re.findall(r"`~/\.local/share/voz`\s\(([\w, ]+)\)", page)
    assert kinds == set(named.split(", "))
    assert "`~/.cache/voz`" in page


def test_the_documents_are_short() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) <= 150
    pages = [readme, *(page.text for page in written() if page.path.parent == Path("docs"))]
    assert sum(len(page.split()) for page in pages) <= 26_000


def test_what_the_spanish_readme_shows_is_what_voz_says(tmp_path: Path) -> None:
    (page,) = (each for each in written() if each.path == Path("README.es.md"))
    shown = next(block for block in page.terminals if block.startswith("$ voz run --language es"))
    typed = re.findall(r"(?:oído|ignorado) +\"(.+?)\"", shown)
    assert len(typed) == 6
    here: dict[str, Any] = {"cwd": tmp_path, "env": {**os.environ, "PYTHONPATH": str(ROOT)}}
    call = ("run", "--text", "-", "--no-sound")
    run = in_process(*call, "--language", "es", input="\n".join(typed), **here)
    assert run.out == shown.partition("\n")[2]
    (tmp_path / "comandos.txt").write_text(page.blocks("text")[0], encoding="utf-8")
    (tmp_path / "voz.toml").write_text(page.blocks("toml")[0], encoding="utf-8")
    assert in_process("build-lm", "comandos.txt", "--out", "lm", **here).code == 0
    run = in_process(*call, input="empieza a escuchar\nsaluda", **here)
    assert "el robot dice «hola, ¿qué tal?»" in run.out


def test_the_spanish_readme_names_all_commands() -> None:
    page = (ROOT / "README.es.md").read_text(encoding="utf-8")
    assert all(f"`{command}`" in page for command in read_sentences(packaged_files("es")))
