"""Limits for the lengths of registers, which are the camera's words: GenApi believes any of them.

It reserves a register's whole length before it reads one byte, on the heap for a read and on the stack for
writing text, where 8 MB end the program. So every access to a register's bytes passes `require_length` first.
"""

from __future__ import annotations

from grabbergui.core.errors import RemoteProtocolError

LONGEST_REGISTER = 16 << 20
"""Bytes: many times the largest look-up table; a read of this size takes seconds."""
LONGEST_TEXT = 1 << 18
"""Bytes of a string's register; the longest known has 1,024, and small stacks 1 MB."""


def require_length(length: int, what: str, most: int = LONGEST_REGISTER) -> None:
    """Raise RemoteProtocolError for a register that is longer than it can be in earnest."""
    if length > most:
        raise RemoteProtocolError(f"{what} has {length} bytes by the description; at most {most} make sense")
