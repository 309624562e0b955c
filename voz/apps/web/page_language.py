"""The pages in the language of a browser: their HTML, with the table of what scripts show."""

from __future__ import annotations

import html
import json
import re
from functools import cache
from pathlib import Path

from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from voz.texts import ENGLISH, languages, pattern, read_texts, text

PAGE_FILES = Path(__file__).with_name("page")

SHOWN = re.compile(r'>\s*([^<>]*[^<>\s])\s*<|aria-label="([^"]+)"')
"""What a page shows or lets be read out: between two tags, or as a label."""


def page_in_own_language(request: Request, name: str) -> Response:
    """Answer with a page in the language that its browser prefers."""
    language = preferred_language(request.headers.get("accept-language", ""))
    return HTMLResponse(page_html(name, language))


def preferred_language(accepted: str) -> str:
    """Return the code of the first language of an Accept-Language that has a table, or English."""
    wanted = []
    for each in accepted.split(","):
        name, _, quality = each.partition(";q=")
        code = name.strip().lower().partition("-")[0]
        if code in languages() and re.fullmatch(r"[01](\.\d{0,3})?", quality or "1"):
            wanted.append((float(quality or 1), code))
    return max(wanted, key=lambda each: each[0], default=(0.0, ENGLISH))[1]


@cache
def page_html(name: str, language: str) -> str:
    """Return a page in a language, with the table of its texts, JSON."""

    def translated(found: re.Match[str]) -> str:
        shown = found[1] or found[2]
        own = text(" ".join(shown.split()), language)
        return found[0].replace(shown, html.escape(own))

    page = SHOWN.sub(translated, (PAGE_FILES / name).read_text("utf-8"))
    page = page.replace('<html lang="en">', f'<html lang="{language}">')
    table = f'<script id="texts" type="application/json">{_table(language)}</script>'
    return page.replace("</head>", f"{table}\n</head>")


def _table(language: str) -> str:
    own = read_texts(language)
    notices = [(english, pattern(english)) for english in own.notices]
    table = json.dumps({"texts": dict(own.texts), "notices": notices}, ensure_ascii=False)
    return table.replace("<", r"\u003c").replace("(?P\\u003c", "(?\\u003c")
