"""Generate the language files: the same as `voz build-lm`, also where voz is not installed."""

import sys
from pathlib import Path

try:
    import voz.cli
except ModuleNotFoundError:
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    import voz.cli

if __name__ == "__main__":
    sys.exit(voz.cli.main(["build-lm", *sys.argv[1:]]))
