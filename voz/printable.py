"""Text of others, made safe for a terminal."""


def printable(text: str) -> str:
    r"""Escape control characters of a line as Python does, such as `\x1b`, `\r` and `\u202e`."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )


def printable_output(line: str) -> str:
    """Make a line that another program printed safe, without its end; tabs become spaces."""
    return printable(line.rstrip().expandtabs())
