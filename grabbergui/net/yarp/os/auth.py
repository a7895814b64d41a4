"""YARP's port authentication: three messages of nonce and HMAC-SHA256, before anything else is said.

The side that accepted speaks first; both must hold the same key. It keeps strangers out, the traffic that
follows is neither secret nor signed.
"""

from __future__ import annotations

import hashlib
import hmac
import os
from collections.abc import Callable

from grabbergui.core.errors import AccessDeniedError

NONCE = 8
DIGEST = 32
MESSAGE = NONCE + DIGEST


class Handshake:
    """One side's part in it: send what `begin` and `received` give, until `done`."""

    def __init__(self, key: bytes, *, accepting: bool, nonce: Callable[[int], bytes] = os.urandom) -> None:
        self.done = False
        self._key = key
        self._accepting = accepting
        self._nonce = nonce
        self._nonces = b""

    def begin(self) -> bytes:
        """The first message of the accepting side; the other begins with silence."""
        return self._message() if self._accepting else b""

    def received(self, message: bytes) -> bytes:
        """Check 40 bytes of the peer; gives the next message, or nothing. Raises AccessDeniedError."""
        self._nonces += message[:NONCE]
        if not hmac.compare_digest(self._digest(), message[NONCE:]):
            raise AccessDeniedError("the peer does not know the key of auth.conf")
        last = len(self._nonces) == 3 * NONCE
        answer = b"" if last else self._message()
        self.done = len(self._nonces) == 3 * NONCE
        return answer

    def _message(self) -> bytes:
        nonce = self._nonce(NONCE)
        self._nonces += nonce
        return nonce + self._digest()

    def _digest(self) -> bytes:
        return hmac.new(self._key, self._nonces, hashlib.sha256).digest()
