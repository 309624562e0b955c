"""README and docs/: what they link to, and the blocks and command lines in them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from make_reference import pages
from recordings import ROOT

BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r'(?:\[[^\]]*\]\(|\bsrc(?:set)?=")([^)\s"]+)')
DESCRIBED = re.compile(r"^::: (\S+)$", re.MULTILINE)
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
INLINE = re.compile(r"(?<!`)`([^`]+)`(?!`)")


class Document(NamedTuple):
    """A page: where it is, from the root, and its text."""

    path: Path
    text: str

    @property
    def prose(self) -> str:
        """All but the blocks."""
        return BLOCK.sub("", self.text)

    def blocks(self, language: str) -> list[str]:
        """The blocks of a language."""
        return [found[3] for found in BLOCK.finditer(self.text) if found[2] == language]

    @property
    def terminals(self) -> list[str]:
        """The blocks that may show what somebody types."""
        return [f[3] for f in BLOCK.finditer(self.text) if f[2] not in ("python", "toml", "json")]


@cache
def written() -> tuple[Document, ...]:
    """The pages that somebody wrote."""
    paths = [*ROOT.glob("*.md"), *sorted((ROOT / "docs").glob("*.md"))]
    return tuple(Document(path.relative_to(ROOT), path.read_text("utf-8")) for path in paths)


def recipe(title: str) -> Document:
    """A part of the cookbook."""
    (page,) = (page for page in written() if page.path == Path("docs/cookbook.md"))
    part = page.text.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    assert part, f"there is no recipe {title}"
    return Document(page.path, part)


@cache
def generated() -> tuple[Document, ...]:
    """The pages that are made from the program."""
    return tuple(Document(Path("docs/reference") / name, text) for name, text in pages().items())


def anchors(text: str) -> set[str]:
    """The anchors of headings which MkDocs and GitHub both make, and those of mkdocstrings."""
    prose = BLOCK.sub("", text)
    slugs = {slug for heading in HEADING.findall(prose) if (slug := _slug(heading)) is not None}
    return slugs | set(DESCRIBED.findall(prose))


def _slug(heading: str) -> str | None:
    plain = re.sub(r"[^\w\s-]", "", re.sub(r"\]\([^)]*\)", "]", heading)).strip().lower()
    collapsed = re.sub(r"[-\s]+", "-", plain)
    return collapsed if collapsed == plain.replace(" ", "-") else None


def broken_links(document: Document, pages: dict[Path, str]) -> Iterator[str]:
    """The links within the project that lead nowhere.

    Args:
        document: which has the links.
        pages: the text of each page by its path.
    """
    for target in LINK.findall(document.prose):
        if target.startswith(("https://", "http://")):
            continue
        name, _, anchor = target.partition("#")
        path = _normal(document.path.parent / name) if name else document.path
        if path not in pages and not (ROOT / path).exists():
            yield f"{document.path}: {target}: there is no such file"
        elif anchor and anchor not in anchors(pages.get(path, "")):
            yield f"{document.path}: {target}: there is no such heading"


def _normal(path: Path) -> Path:
    return (ROOT / path).resolve().relative_to(ROOT)


def commands_shown(document: Document) -> Iterator[str]:
    """The calls of `voz` in blocks, without comments: whole ones, as a user would type them."""
    for block in document.terminals:
        for line in block.splitlines():
            call = re.sub(r"^\$ ", "", line)
            if call.startswith("voz "):
                yield call.partition(" #")[0]


def commands_named(document: Document) -> Iterator[str]:
    """The calls of `voz` in the text, which may leave out what is not the matter there."""
    for found in INLINE.findall(document.prose):
        call = " ".join(found.split())
        if re.match(r"voz [a-z-]", call):
            yield call
