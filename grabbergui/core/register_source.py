"""Registers of plain bytes that are not features, such as FileAccessBuffer."""

from __future__ import annotations

from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.feature_source import FeatureSource


class RegisterSource(FeatureSource):
    """Features and registers of plain bytes, by which a camera's files and look-up tables are moved."""

    def register_length(self, name: str) -> int:
        """Return the size in bytes of a register that is not a feature, such as FileAccessBuffer.

        Raises FeatureAccessError if there is none; remote sources have no such registers.
        """
        raise self._has_no_register(name)

    def read_register(self, name: str, length: int) -> bytes:
        """Read the first `length` bytes of a register from the camera. Raises as `register_length`."""
        raise self._has_no_register(name)

    def write_register(self, name: str, content: bytes) -> None:
        """Write bytes to the beginning of a register. Raises as `register_length`."""
        raise self._has_no_register(name)

    def _has_no_register(self, name: str) -> FeatureAccessError:
        return FeatureAccessError(
            f"{self.info.title} gives no access to the register {name}; only a camera that is attached"
            " to this computer does",
            name,
        )
