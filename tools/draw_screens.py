"""Draw the operator page on four screens, light and dark, with each list of `tests/page_layout.py`.

Run `python tools/draw_screens.py`, or with the names of some lists, as `forty`. The pictures go to
build/page; what is cut or covered is printed. It needs what `tools/draw_page.py` needs.
"""

from __future__ import annotations

import sys
from pathlib import Path

from draw_page import SCHEMES, context, drawing, keep
from playwright.sync_api import Browser

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from browser_page import opened
from operator_page import page_robot
from page_layout import LISTS, SCREENS, faults, language, options, scenes


def draw(browser: Browser, link: str, name: str) -> None:
    """Draw the page of a robot with a list, scene by scene."""
    for scheme in SCHEMES:
        for screen in SCREENS:
            with context(browser, screen, scheme, language(name)) as there:
                page = opened(there, link)
                for scene in scenes(page):
                    keep(page, f"{name}-{scene}", screen, scheme)
                    for fault in faults(page):
                        print(name, scene, screen, fault)


def main() -> None:
    """Draw the page with the lists that are named, or with all."""
    with drawing() as (browser, environment, folder):
        for name in sys.argv[1:] or LISTS:
            (folder / name).mkdir()
            given = options(name, folder / name)
            with page_robot(environment, "--no-sound", *given) as robot:
                draw(browser, robot.link, name)


if __name__ == "__main__":
    main()
