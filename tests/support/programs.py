"""The program in a process of its own, for tests that look at how it runs and ends."""

import sys

ALONE = """
from grabbergui.models.sources import SourceListModel
SourceListModel.start = lambda self: None
"""
"""Other sources are not looked for: to import each kind takes as long as all that these tests look at."""


def window_command(*options):
    """Return the command for a window without a screen that looks for no other sources."""
    main = "import sys; from grabbergui.cli import main; sys.exit(main(sys.argv[1:]))"
    return [sys.executable, "-c", ALONE + main, "gui", "--offscreen", *options]
