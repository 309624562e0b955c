"""Draw the operator page, five screens on a laptop and a phone, light and dark, and a card.

Run `python tools/draw_page.py`. All twenty pictures go to build/page, those of the documents to
docs/page-*.png, how the robot moves on the page to docs/page.gif, the card of the commands that
come with voz to docs/card.png. It needs what the tests need: Debian's chromium, and playwright.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from browser_page import SECONDS, drive, ear, opened, tap  # noqa: E402
from operator_page import PageRobot, page_robot  # noqa: E402
from operator_page import opened as opened_without_browser  # noqa: E402
from page_layout import SCREENS as PIXELS  # noqa: E402

ALL = ROOT / "build" / "page"
SIZES = ("laptop", "phone")
SCHEMES = ("light", "dark")
SCREENS = ("first", "driving", "asleep", "lost", "taken-over")
COLORS = 128
"""Of a picture in the documents: what is drawn flat needs no more."""

A4_WIDTH = 794
"""px, at 96 to the inch."""

GAP = 16
"""Between the screens of a sheet, px."""

DRIVE = (("go forward", 4), *[("turn left", 1)] * 4, ("turn left", 8), ("fold arm", 3), ("stop", 3))
"""What is tapped for docs/page.gif, and how many pictures are drawn after each."""

FRAME = 300
"""How long each of these is shown, ms."""

SMALL = (640, 400)
"""Their size, px."""

SECONDS_AWAY = 4500
"""How long the robot has been lost on the picture, ms."""


@contextmanager
def context(
    browser: Browser, size: str, scheme: str, language: str = "en"
) -> Iterator[BrowserContext]:
    """A browser on a laptop or a phone."""
    width, height = PIXELS[size]
    phone = size != "laptop"
    made = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme="dark" if scheme == "dark" else "light",
        locale=language,
        permissions=["microphone"],
        is_mobile=phone,
        has_touch=phone,
    )
    yield made
    made.close()


def keep(page: Page, screen: str, size: str, scheme: str) -> None:
    """Keep how the page looks now, once what moves in it has arrived."""
    page.wait_for_timeout(500)
    page.screenshot(path=ALL / f"{screen}-{size}-{scheme}.png")


def draw(browser: Browser, robot: PageRobot, size: str, scheme: str) -> None:
    """Draw a page from its first screen until it has lost the robot, which ends there."""
    with context(browser, size, scheme) as there:
        page = opened(there, robot.link)
        expect(page.locator("#heard")).to_have_text("Touch Drive to begin.")
        keep(page, "first", size, scheme)
        drive(page)
        expect(ear(page)).to_have_text("asleep")
        keep(page, "asleep", size, scheme)
        tap(page, "go forward")
        page.wait_for_timeout(3500)
        tap(page, "turn left")
        page.wait_for_timeout(3500)
        keep(page, "driving", size, scheme)
        with opened_without_browser(robot, **{"User-Agent": "Mozilla/5.0 (iPad)"}) as other:
            other.drive(over=True)
            expect(page.locator("#notice")).to_be_visible()
            expect(page.locator("#motion-word")).to_have_text("STANDING")
            keep(page, "taken-over", size, scheme)
        expect(page.get_by_role("button", name="Drive", exact=True)).to_be_enabled()
        drive(page)
        tap(page, "go forward")
        expect(page.locator("#motion-word")).to_have_text("FORWARD")
        robot.robot.process.kill()
        page.wait_for_timeout(SECONDS_AWAY)
        keep(page, "lost", size, scheme)


def draw_moving(browser: Browser, robot: PageRobot) -> None:
    """Draw how the robot moves on the page of a laptop as commands are tapped."""
    frames = []
    with context(browser, "laptop", "light") as there:
        page = opened(there, robot.link)
        drive(page)
        tap(page, "start speech")
        for command, count in DRIVE:
            page.locator("#stop").click() if command == "stop" else tap(page, command)
            for _ in range(count):
                page.wait_for_timeout(FRAME)
                frames.append(Image.open(BytesIO(page.screenshot())).convert("RGB").resize(SMALL))
    ends = Image.new("RGB", (SMALL[0], 2 * SMALL[1]))  # which have all colors
    ends.paste(frames[0], (0, 0))
    ends.paste(frames[-1], (0, SMALL[1]))
    palette = ends.quantize(COLORS, dither=Image.Dither.NONE)
    flat = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    path = ROOT / "docs" / "page.gif"
    flat[0].save(path, save_all=True, append_images=flat[1:], duration=FRAME, loop=0)


def draw_card(browser: Browser) -> None:
    """Draw the card of the commands that come with voz."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "voz", "commands", "--card", "--lm", str(ROOT / "lm")]
        subprocess.run(command, cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True)
        page = browser.new_page(viewport={"width": A4_WIDTH, "height": 600})
        page.goto(f"file://{folder}/commands.html")
        page.screenshot(path=ALL / "card.png", full_page=True)
    keep_in_documents(Image.open(ALL / "card.png"), "card")


def sheet(scheme: str) -> Image.Image:
    """Return the five screens of a phone, side by side."""
    pictures = [Image.open(ALL / f"{screen}-phone-{scheme}.png") for screen in SCREENS]
    width, height = pictures[0].size
    whole = Image.new("RGB", (len(pictures) * (width + GAP) - GAP, height), "#808890")
    for at, picture in enumerate(pictures):
        whole.paste(picture, (at * (width + GAP), 0))
    return whole


def keep_in_documents(picture: Image.Image, name: str) -> None:
    """Write a small PNG into docs."""
    flat = picture.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
    flat.save(ROOT / "docs" / f"{name}.png", optimize=True)


@contextmanager
def drawing() -> Iterator[tuple[Browser, dict[str, str], Path]]:
    """A browser, an environment without a sound card, and a folder for what is written."""
    ALL.mkdir(parents=True, exist_ok=True)
    expect.set_options(timeout=SECONDS)
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        config = Path(name) / "alsa.conf"
        config.write_text("pcm.default { type hw card 99 }")
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium",
            args=["--no-sandbox", "--disable-gpu", "--use-fake-ui-for-media-stream",
                  "--use-fake-device-for-media-stream"],
        )  # fmt: skip
        yield browser, os.environ | {"ALSA_CONFIG_PATH": str(config)}, Path(name)
        browser.close()


def main() -> None:
    """Drive simulated robots by their pages, and draw the pages."""
    with drawing() as (browser, environment, _):
        for size in SIZES:
            for scheme in SCHEMES:
                with page_robot(environment) as robot:
                    draw(browser, robot, size, scheme)
                driving = Image.open(ALL / f"driving-{size}-{scheme}.png")
                keep_in_documents(driving, f"page-{size}-{scheme}")
        with page_robot(environment) as robot:
            draw_moving(browser, robot)
        draw_card(browser)
    for scheme in SCHEMES:
        keep_in_documents(sheet(scheme), f"page-screens-{scheme}")


if __name__ == "__main__":
    main()
