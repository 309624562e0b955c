"""Files that are cut, flipped, mixed up: what disks, editors and killed programs leave."""

from __future__ import annotations

import random

INSERTED = (b"nan", b"-1e400", b"99999999999999999999", b"\\end\\", b"%s%n", b"A" * 5000, b"\0")


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Damage a file in one of seven ways."""
    broken, lines = bytearray(data), data.split(b"\n")
    at, other = sorted(chance.randrange(len(data)) for _ in range(2))
    one, two = sorted(chance.randrange(len(lines)) for _ in range(2))
    match chance.randrange(7):
        case 0:
            return data[:at]
        case 1:
            del broken[at : other + 1]
        case 2:
            broken[at:at] = chance.choice(INSERTED)
        case 3:
            for _ in range(chance.randint(1, 8)):
                broken[chance.randrange(len(broken))] ^= 1 << chance.randrange(8)
        case 4:
            lines[one], lines[two] = lines[two], lines[one]
            return b"\n".join(lines)
        case 5:
            return b"\n".join(lines[:one] + lines[two + 1 :])
        case _:
            return b"\n".join(lines[:one] + lines[two:] + lines[one:])
    return bytes(broken)
