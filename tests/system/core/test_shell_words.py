"""Words for a shell are read back as they were, and nothing in them acts on a terminal."""

import shutil
import subprocess

import pytest

from grabbergui.core.shell_words import shell_line, shell_word
from patience import PROGRAM

WORDS = [
    "plain",
    "",
    "two words",
    "$(touch pwned)`touch pwned`;'\"\\",
    "a\x03\ntouch pwned\n",
    "\x1b[201~\ttouch 'pwned'\\\r",
    "é\x9b\u202e\u200b∞\udc80",
]


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_a_shell_reads_the_text_back(shell, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    line = shell_line(["printf", r"%s\0", *WORDS])
    assert line.isprintable()
    done = subprocess.run(
        [shell, "-c", line], stdout=subprocess.PIPE, timeout=PROGRAM, cwd=tmp_path, check=True
    )
    assert done.stdout.decode("utf-8", "surrogateescape").split("\0")[:-1] == WORDS
    assert not list(tmp_path.iterdir())


def test_simple_words_stay_as_they_are():
    assert shell_line(["grabbergui", "set", "gige:", "Gain=1.5"]) == "grabbergui set gige: Gain=1.5"
    assert shell_word("left eye") == "'left eye'"
