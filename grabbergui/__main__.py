"""``python -m grabbergui``: the same as the ``grabbergui`` command."""

import sys

from grabbergui.cli import main

if __name__ == "__main__":
    sys.exit(main())
