"""A command line of bash that is being typed: its words, and how a word enters it.

Bash replaces only the end of the line by a completion, and inserts it as it is. So a word is inserted without
the part that stays, and quoted as the line quotes it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_SAFE = re.compile(r"[\w%+=:,./@-]")
"""Characters that mean nothing to bash; `\\w` includes the letters of all languages."""
_ESCAPED_IN_DOUBLE_QUOTES = '\\$`"'


@dataclass(frozen=True)
class BashLine:
    """The line up to the cursor."""

    words: tuple[str, ...]
    "The words after the program's name, without quotation; the last one is being typed, and may be empty."
    quote: str
    "The quotation that is open at the cursor: empty, a single or a double quote."
    kept: int
    "Characters of the last word that bash keeps before a completion."

    @classmethod
    def parse(cls, line: str, breaks: str = "") -> BashLine:
        """Read a line. `breaks` is bash's COMP_WORDBREAKS: it keeps a word up to the last unquoted one."""
        words: list[str] = []
        word: str | None = None
        quote, kept, escaped = "", 0, False
        for at, sign in enumerate(line):
            if escaped:
                word, escaped = f"{word or ''}{sign}", False
            elif quote and sign == quote:
                quote = ""
            elif quote == "'":
                word = f"{word}{sign}"
            elif sign == "\\" and (not quote or line[at + 1 : at + 2] in tuple(_ESCAPED_IN_DOUBLE_QUOTES)):
                escaped = True
            elif quote:
                word = f"{word}{sign}"
            elif sign in "'\"":
                quote, word = sign, word or ""
                kept = len(word)
            elif sign.isspace():
                if word is not None:
                    words.append(word)
                word, kept = None, 0
            else:
                word = f"{word or ''}{sign}"
                kept = len(word) if sign in breaks else kept
        return cls((*words, word or "")[1:], quote, kept)

    def inserted(self, word: str) -> str | None:
        """Return the text that makes `word` the last word of this line; None if it cannot be written.

        The word has no control characters. Bash closes a quotation by itself, unless the text already ends in
        this sign.
        """
        rest = word[self.kept :]
        if self.quote == "'":
            quoted = rest.replace("'", "'\\''")
            return quoted.removesuffix("'") if rest.endswith("'") else quoted
        if self.quote:
            # Bash expands an exclamation mark in double quotes, and its backslash would stay in the word.
            if "!" in rest:
                return None
            quoted = "".join(f"\\{sign}" if sign in _ESCAPED_IN_DOUBLE_QUOTES else sign for sign in rest)
            return f'{quoted}"' if rest.endswith('"') else quoted
        return "".join(sign if _SAFE.match(sign) else f"\\{sign}" for sign in rest)
