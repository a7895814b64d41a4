"""The words that completion proposes at each place of a command line."""

import subprocess
import sys

from patience import PROGRAM


def test_commands_are_completed_without_the_imports_of_the_commands():
    code = (
        "import sys; sys.argv = ['grabbergui', '--complete', 'fish', 'grabbergui', 'rec']\n"
        "from grabbergui.__main__ import main; main()\n"
        "print([name for name in ('numpy', 'grabbergui.cli') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PROGRAM)
    assert done.stdout.splitlines()[:2] == ["words", "record\trecord frames; play them back with file:PATH"]
    assert done.stdout.splitlines()[-1] == "[]"
