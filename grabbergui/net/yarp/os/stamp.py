"""The envelope of a message: a counter and a time."""

from __future__ import annotations

from dataclasses import dataclass

_WRAP = 2**31
_LATEST = 2**63 / 1e9
"Seconds since 1970 whose nanoseconds still are an integer of 64 bits: the year 2262."


@dataclass(frozen=True)
class Stamp:
    """YARP's envelope, `COUNT TIME` as text."""

    count: int
    "0 to 2³¹-1, then from 0 again."
    time: float
    "Seconds since 1970; YARP's 15 digits keep some 10 microseconds of it."

    def encode(self) -> str:
        """Return the text on the wire."""
        return f"{self.count % _WRAP} {self.time:.15g}"

    @classmethod
    def decode(cls, text: str) -> Stamp | None:
        """Return the stamp in an envelope; None where it is something else, which is legal."""
        words = text.split()
        try:
            stamp = cls(int(words[0]), float(words[1]))
        except (ValueError, IndexError):
            return None
        return stamp if abs(stamp.time) < _LATEST and 0 <= stamp.count < _WRAP else None
