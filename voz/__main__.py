"""`python -m voz` is the `voz` command."""

import sys

from voz.cli import main

sys.exit(main())
