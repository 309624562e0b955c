"""The page is in the language of its browser, whatever the robot's is."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_page import SECONDS, for_a_browser, opened
from operator_page import PageRobot, page_robot
from operator_page import opened as opened_without_browser
from playwright.sync_api import Browser, Page, expect
from spanish import spanish_robot

from voz.apps.web.page_language import page_html, preferred_language
from voz.config import default_commands
from voz.speech.synthesis import render
from voz.texts import PLACEHOLDER, languages, pattern, read_texts, text


@pytest.mark.parametrize(
    ("accepted", "language"),
    [
        ("es-MX,es;q=0.9,en;q=0.8", "es"),
        ("sv,fr-CA;q=0.5,en;q=0.4", "fr"),
        ("en-US,en;q=0.9,es;q=0.8", "en"),
        ("en;q=0.1, ES ;q=0.2", "es"),
        ("sv", "en"),
        ("", "en"),
        ("es;q=nan,fr;q=x,*;q=0.5", "en"),
    ],
)
def test_the_first_language_that_a_browser_prefers_and_voz_has(
    accepted: str, language: str
) -> None:
    assert preferred_language(accepted) == language


@pytest.mark.parametrize("language", languages())
def test_a_page_says_which_language_it_has_and_brings_its_texts(language: str) -> None:
    page = page_html("index.html", language)
    heading = f'<h2 id="heard-title">{text("Heard and said until then", language)}</h2>'
    assert heading in page_html("session.html", language)
    assert f'<html lang="{language}">' in page
    assert f'<button id="main-button" type="button" disabled>{text("Drive", language)}<' in page
    (table,) = re.findall(r'<script id="texts" type="application/json">(.*?)</script>', page)
    assert json.loads(table)["texts"] == dict(read_texts(language).texts)
    assert ("operator page" in page.replace(table, "")) == (language == "en")


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Somebody says "avanza" in a quiet room now and then."""
    folder = tmp_path_factory.mktemp("said")
    render("avanza", "espeak-ng:es", folder / "avanza.wav")
    return for_a_browser(folder / "avanza.wav", folder / "said.wav")


@pytest.fixture(scope="module")
def robot(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card) as robot:
        yield robot


def english_on(page: Page, replies: bool = True) -> set[str]:
    """What is English on a page, seen or hidden, of all that its table translates.

    A robot that speaks English may show `replies`.
    """
    script = """() => {
        const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
        const shown = [document.title];
        while (walker.nextNode()) shown.push(walker.currentNode.data);
        for (const one of document.querySelectorAll("[aria-label]")) shown.push(one.ariaLabel);
        return shown;
    }"""
    shown = {" ".join(each.split()) for each in page.evaluate(script)}
    shown -= {*default_commands().replies} if replies else set()
    own = read_texts(page.locator("html").get_attribute("lang") or "").texts
    keys = [key for key in own if own[key] != key and len(PLACEHOLDER.sub("", key)) > 3]
    return {each for each in shown for key in keys if re.fullmatch(pattern(key), each)}


@pytest.mark.realtime
@pytest.mark.parametrize(
    ("locale", "free", "drives", "moves"),
    [
        ("es-ES", "no conduce nadie", "conduces tú", "ADELANTE 0.10 m/s"),
        ("fr-FR", "personne ne conduit", "tu conduis", "AVANCE 0.10 m/s"),
    ],
)
def test_all_of_the_page_is_in_the_language_of_the_browser(
    robot: PageRobot, browser: Browser, locale: str, free: str, drives: str, moves: str
) -> None:
    language = locale[:2]
    expect.set_options(timeout=SECONDS)
    context = browser.new_context(locale=locale, permissions=["microphone"])
    context.set_default_timeout(SECONDS)
    page = opened(context, robot.link)
    expect(page.locator("html")).to_have_attribute("lang", language)
    expect(page.locator("#driver")).to_have_text(free)
    assert english_on(page) == set()
    page.get_by_role("button", name=text("Drive", language), exact=True).click()
    expect(page.locator("#driver")).to_have_text(drives)
    page.locator("#commands").get_by_role("button", name="go forward", exact=True).click()
    expect(page.locator("#motion")).to_have_text(moves)
    page.locator("#stop").click()
    expect(page.locator("#stop-word")).to_have_text(text("stopped", language))
    page.locator("#rehearse").check()
    rehearsing = text("rehearsal: commands are recognized, and only stop is obeyed", language)
    expect(page.locator("#log")).to_contain_text(rehearsing)
    page.locator("#commands").get_by_role("button", name="go back", exact=True).click()
    expect(page.locator("#heard .why")).to_have_text(text("rehearsal: nothing moves", language))
    page.locator("#rehearse").uncheck()
    expect(page.locator("#motion")).to_have_text(text("STANDING", language))
    with opened_without_browser(robot) as other:
        other.drive(over=True)
        program = text("program", language)
        expect(page.locator("#notice-text")).to_contain_text(program)
        expect(page.locator("#log")).to_contain_text(program)
        assert english_on(page) == set()
    assert page.complaints == []  # type: ignore[attr-defined]
    context.close()


@pytest.mark.realtime
def test_a_spanish_robot_and_its_page_have_no_english(
    no_sound_card: dict[str, str], browser: Browser, tmp_path: Path
) -> None:
    expect.set_options(timeout=SECONDS)
    context = browser.new_context(locale="es-ES", permissions=["microphone"])
    with page_robot(no_sound_card, "--config", str(spanish_robot(tmp_path))) as robot:
        assert "página del operador: " in robot.robot.words
        page = opened(context, robot.link)
        page.get_by_role("button", name="Conducir", exact=True).click()
        page.locator("#commands").get_by_role("button", name="avanza", exact=True).click()
        expect(page.locator("#motion")).to_have_text("ADELANTE 0.10 m/s")
        expect(page.locator("#log")).to_contain_text("bip bip. Te escucho")
        page.locator("#stop").click()
        expect(page.locator("#motion")).to_have_text("PARADO")
        page.get_by_label("manos libres").check()
        expect(page.locator("#motion")).to_have_text("ADELANTE 0.10 m/s")  # it was said
        expect(page.locator("#heard .what")).to_have_text("avanza")
        page.locator("#stop").click()
        expect(page.locator("#motion")).to_have_text("PARADO")
        assert english_on(page, replies=False) == set()
        texts = page.locator("body").inner_text()
        assert not re.findall(r"(?i)\b(the|is|not|robot stops|drive|heard|say|and)\b", texts)
        assert robot.robot.commands()[:3] == ["empieza a escuchar", "avanza", "stop"]
        assert "browser" in {event["source"] for event in robot.robot.of("utterance")}
    context.close()
