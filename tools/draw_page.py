"""Draw docs/page-*.png: the operator page on a laptop and a phone, light and dark.

Run `python tools/draw_page.py`. It needs what the tests need: Debian's chromium, and playwright.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Browser, Page, expect, sync_playwright

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from operator_page import PageRobot, page_robot, with_noise  # noqa: E402
from operator_page import heard as hearing  # noqa: E402
from operator_page import opened as opened_page  # noqa: E402

SIZES = {"laptop": (1366, 768), "phone": (390, 844)}
SCHEMES = ("light", "dark")

SAID = (
    "commands/festival_slt__start_speech.flac",
    "near_misses/festival_slt__turn_around.flac",
    "commands/festival_slt__go_forward.flac",
    "commands/festival_slt__turn_left.flac",
)


def speak(robot: PageRobot) -> None:
    """Let somebody speak to the robot, so that there is something to see."""
    with opened_page(robot) as page:
        page.drive(over=True)  # the browser may not have gone yet
        with hearing(robot, page) as microphone:
            for name in SAID:
                microphone.begin()
                microphone.speak(with_noise(ROOT / "audio_fixtures" / name, 0.3, 0.6), page)
                microphone.end()
                page.stay(0.5)
        robot.api.post("/api/stop").raise_for_status()


def draw(browser: Browser, robot: PageRobot, size: str, scheme: str) -> None:
    """Keep how the page looks while it drives."""
    width, height = SIZES[size]
    context = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme="dark" if scheme == "dark" else "light",
        device_scale_factor=1.5,
        permissions=["microphone"],
    )
    page = context.new_page()
    page.goto(robot.link)
    page.get_by_role("button", name="Drive", exact=True).click()
    page.get_by_role("button", name="Use this microphone").click()
    expect(page.locator("#talk")).to_be_visible()
    tap(page, "rotate left")
    page.wait_for_timeout(1500)
    tap(page, "point beer")
    page.wait_for_timeout(2500)
    page.screenshot(path=ROOT / "docs" / f"page-{size}-{scheme}.png")
    page.keyboard.press("Space")
    expect(page.locator("#stop")).to_have_text("stopped")
    context.close()


def tap(page: Page, text: str) -> None:
    """Give a command by its button, and look at the top of the page again."""
    page.locator("#commands").get_by_role("button", name=text, exact=True).click()
    page.evaluate("scrollTo(0, 0)")


def main() -> None:
    """Drive a simulated robot by its page, and draw the page."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        config = Path(folder) / "alsa.conf"
        config.write_text("pcm.default { type hw card 99 }")
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium",
            args=["--no-sandbox", "--disable-gpu", "--use-fake-ui-for-media-stream",
                  "--use-fake-device-for-media-stream"],
        )  # fmt: skip
        with page_robot(os.environ | {"ALSA_CONFIG_PATH": str(config)}) as robot:
            for size in SIZES:
                for scheme in SCHEMES:
                    speak(robot)
                    draw(browser, robot, size, scheme)
        browser.close()


if __name__ == "__main__":
    main()
