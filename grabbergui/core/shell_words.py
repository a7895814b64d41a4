"""Words of a command line that a person pastes into a shell: copied commands, and commands in messages.

In a paste, control characters act on the terminal before any quotation counts: Ctrl-C ends the line, and the
rest is the next command. So a word is quoted, and contains nothing but printable characters.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable


def shell_word(text: str) -> str:
    r"""Return a word that the shell reads as this text; one with control characters as `$'\x1b'`.

    Bash, zsh and POSIX's shell of 2024 read the latter, fish does not.
    """
    if text.isprintable():
        return shlex.quote(text)
    return "$'" + "".join(map(_spelled, text)) + "'"


def shell_line(words: Iterable[str]) -> str:
    """Return a command of these words."""
    return " ".join(map(shell_word, words))


def _spelled(sign: str) -> str:
    if sign in "\\'":
        return f"\\{sign}"
    if sign.isprintable():
        return sign
    return "".join(f"\\x{byte:02x}" for byte in sign.encode("utf-8", "surrogateescape"))
