"""Generate the language files: the same as `voz build-lm`, also where voz is not installed."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

try:
    from voz.cli import main
except ModuleNotFoundError as error:
    print(
        f"build_lm.py: this Python has no {error.name}; run `make install`, "
        "then .venv/bin/python tools/build_lm.py",
        file=sys.stderr,
    )
    sys.exit(2)

if __name__ == "__main__":
    sys.exit(main(["build-lm", *sys.argv[1:]]))
