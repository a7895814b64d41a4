"""GenApi's port: reads and writes the registers of a node map, inside its lock (`map_lock`)."""

from __future__ import annotations

import logging
from typing import Protocol

from genicam import genapi

from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.driver.genapi.register_length import require_length

log = logging.getLogger(__name__)


class Registers(Protocol):
    """The part of a `Device` that GenApi needs; other modules than cameras have one, too."""

    def read(self, address: int, length: int) -> bytes:
        """Return exactly `length` bytes."""

    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`."""


class RegisterPort(genapi.AbstractPort):  # type: ignore[misc]  # the library has no types
    """Reads and writes registers of a `Device` for GenApi.

    An exception of the device does not pass through C++, so it is stored in `failure` for the caller. An
    unexpected one becomes a TransportError, since GenApi would end the process.
    """

    def __init__(self, device: Registers) -> None:
        super().__init__()
        self._device = device
        self.failure: GrabberError | None = None
        "The last error, until `take_failure` clears it."

    def read(self, address: int, length: int) -> bytes:
        """Called by GenApi."""
        try:
            require_length(length, f"the register at 0x{address:X}")
            return self._device.read(address, length)
        except Exception as error:
            raise self._kept(error) from error

    def write(self, address: int, value: bytes) -> None:
        """Called by GenApi."""
        try:
            require_length(len(value), f"the register at 0x{address:X}")
            self._device.write(address, bytes(value))
        except Exception as error:
            raise self._kept(error) from error

    def get_access_mode(self) -> int:
        """Called by GenApi."""
        return int(genapi.EAccessMode.RW)

    def is_open(self) -> bool:
        """Called by GenApi."""
        return True

    def get_principal_interface_type(self) -> int:
        """Called by GenApi."""
        return int(genapi.EInterfaceType.intfIPort)

    def _kept(self, error: Exception) -> RuntimeError:
        """Return the exception that GenApi accepts; `take_failure` returns the reason."""
        if not isinstance(error, GrabberError):
            error = TransportError(f"{type(error).__name__}: {error}")
        self.failure = error
        return RuntimeError(str(error))

    def take_failure(self) -> GrabberError | None:
        """Return and clear the error behind GenApi's last exception."""
        failure, self.failure = self.failure, None
        return failure
