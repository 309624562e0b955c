"""Text of others on a terminal: seen, and not obeyed by it. Pure."""


def printable(text: str) -> str:
    r"""Write what a terminal would obey as Python does, such as `\x1b`, `\r` and `\u202e`.

    Args:
        text: one line, perhaps with names of files, typed text or messages of other programs.
    """
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )
