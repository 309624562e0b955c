"""SHA-256 as `hashlib` has it, without the 3.5 MB of OpenSSL that importing `hashlib` loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

__all__ = ["sha256"]

if TYPE_CHECKING:
    from hashlib import sha256
else:
    try:
        from _sha2 import sha256  # Python 3.12 and later
    except ImportError:
        try:
            from _sha256 import sha256
        except ImportError:  # a Python that was built without algorithms of its own
            from hashlib import sha256
