"""YARP's handshake with a shared key, for both ends."""

from __future__ import annotations

import hashlib
import hmac
import os
from collections.abc import Callable

from grabbergui.core.errors import AccessDeniedError

_NONCE_BYTES = 8
_DIGEST_BYTES = 32
_HANDSHAKE_BYTES = _NONCE_BYTES + _DIGEST_BYTES


class Handshake:
    """One side of the authentication: send what `begin` and `received` return, until `done`."""

    def __init__(self, key: bytes, *, accepting: bool, nonce: Callable[[int], bytes] = os.urandom) -> None:
        self.done = False
        self._key = key
        self._accepting = accepting
        self._nonce = nonce
        self._nonces = b""

    def begin(self) -> bytes:
        """Return the first message of the accepting side; the other sends nothing first."""
        return self._message() if self._accepting else b""

    def received(self, message: bytes) -> bytes:
        """Check 40 bytes of the peer; return the next message, empty if none. Raises AccessDeniedError."""
        self._nonces += message[:_NONCE_BYTES]
        if not hmac.compare_digest(self._digest(), message[_NONCE_BYTES:]):
            raise AccessDeniedError("the peer does not know the key of auth.conf")
        last = len(self._nonces) == 3 * _NONCE_BYTES
        answer = b"" if last else self._message()
        self.done = len(self._nonces) == 3 * _NONCE_BYTES
        return answer

    def _message(self) -> bytes:
        nonce = self._nonce(_NONCE_BYTES)
        self._nonces += nonce
        return nonce + self._digest()

    def _digest(self) -> bytes:
        return hmac.new(self._key, self._nonces, hashlib.sha256).digest()
