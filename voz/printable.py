"""Text of others, made safe for a terminal."""


def printable(text: str) -> str:
    r"""Escape control characters of a line as Python does, such as `\x1b`, `\r` and `\u202e`."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )
