"""Words for a shell, as bash, zsh and the POSIX shell of 2024 read them."""

from __future__ import annotations

import pytest

from grabbergui.core.shell_words import shell_line, shell_word


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("plain", "plain"),
        ("", "''"),
        ("two words", "'two words'"),
        ("it's", "'it'\"'\"'s'"),
        ("a\x03b", r"$'a\x03b'"),
        ("a\n'b\\", r"$'a\x0a\'b\\'"),
        ("\u00e9\u200b", "$'\u00e9" + r"\xe2\x80\x8b'"),
        ("\udc80", r"$'\x80'"),
    ],
)
def test_a_word_is_quoted_and_printable(text: str, word: str) -> None:
    assert shell_word(text) == word
    assert shell_word(text).isprintable()


def test_a_command_is_its_words() -> None:
    words = ["grabbergui", "set", "gige:", "Gain=1.5", "left eye"]
    assert shell_line(words) == "grabbergui set gige: Gain=1.5 'left eye'"
