"""What a person calls the device of a page, from what its browser says of itself. Pure."""

from __future__ import annotations

DEVICES = (
    ("iPhone", "iPhone"),
    ("iPad", "iPad"),
    ("CrOS", "Chromebook"),
    ("Windows", "Windows PC"),
    ("Macintosh", "Mac"),
    ("Linux", "Linux PC"),
)
"""Words of a User-Agent, and the device; the first that is found counts."""

PROGRAM = "program"
"""What is no browser."""


def device_name(user_agent: str) -> str:
    """Return a name such as "iPhone" or "Android phone"."""
    if "Mozilla/" not in user_agent:
        return PROGRAM
    if "Android" in user_agent:
        return "Android phone" if "Mobile" in user_agent else "Android tablet"
    return next((name for word, name in DEVICES if word in user_agent), "browser")
