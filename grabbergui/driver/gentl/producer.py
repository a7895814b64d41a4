"""GenTL producers: finding them, opening each once per process, the cameras they list, their errors."""

from __future__ import annotations

import contextlib
import os
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from genicam import gentl

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    MissingFileError,
    SourceUnavailableError,
)
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri

GONE = (gentl.IoException, gentl.InvalidHandleException, gentl.ClosedException, gentl.NotInitializedException)
"""Exceptions that producers raise for a handle whose camera is gone."""

_CODE = re.compile(r"\(ID: (-?\d+)\)")
_MESSAGE = re.compile(r"Message from the source: (.*?)\)? \(ID:", re.DOTALL)


@contextmanager
def answering(what: str) -> Iterator[None]:
    """Turn a producer's refusal of `what` into DeviceLostError, AckTimeoutError or DeviceStatusError."""
    try:
        yield
    except gentl.GenericException as error:
        raise failure(what, error) from error


@contextmanager
def opening(what: str) -> Iterator[None]:
    """As `answering`, and a module that somebody else has open gives AccessDeniedError."""
    try:
        yield
    except (gentl.AccessDeniedException, gentl.ResourceInUseException) as error:
        raise AccessDeniedError(
            f"{what}: the producer refuses, as another application has it open: {reason_of(error)}"
        ) from error
    except gentl.GenericException as error:
        raise failure(what, error) from error


def failure(what: str, error: Exception) -> GrabberError:
    """Our word for a producer's exception."""
    message = f"{what}: the producer answered: {reason_of(error)}"
    if isinstance(error, GONE):
        return DeviceLostError(message)
    if isinstance(error, gentl.TimeoutException):
        return AckTimeoutError(message)
    code = _CODE.search(str(error))
    return DeviceStatusError(message, int(code[1]) if code else int(gentl.GC_ERROR_LIST.GC_ERR_ERROR))


def reason_of(error: Exception) -> str:
    """The producer's own message, without the binding's frame around it."""
    text = str(error)
    match = _MESSAGE.search(text)
    return (match[1].strip() if match else "") or text


SEARCH_PATH = "GENICAM_GENTL64_PATH"
"""Environment variable with the folders (or files) of producers, as the GenTL standard names it."""
SEARCH_MS = 1000
"""A producer may look for interfaces or cameras so long where nobody said otherwise."""


@dataclass(frozen=True)
class FoundCamera:
    """A camera that a producer lists."""

    info: Any
    "gentl.DeviceInfo."
    device: DeviceInfo

    def answers_to(self, name: str) -> bool:
        """Whether `name` is its GenTL id, serial number, user-defined name or display name."""
        names = (self.info.id_, self.device.serial, self.device.user_name, text_of(self.info, "display_name"))
        return not name or name in names


class Producer:
    """An open producer. The standard allows one opening per process, so cameras share it; any thread."""

    _open: ClassVar[dict[Path, Producer]] = {}
    _lock: ClassVar = threading.RLock()

    def __init__(self, path: Path) -> None:
        self.path = path
        self._users = 0
        self._interfaces: dict[str, Any] = {}
        self._library = gentl.GenTLProducer.create_producer()
        try:
            self._library.open(str(path))
            self._system = self._library.create_system()
            self._system.open()
        except gentl.GenericException as error:
            if self._library.is_open():
                self._library.close()
            raise SourceUnavailableError(
                f"{path} cannot be used as a GenTL producer: {reason_of(error)}"
            ) from error

    @classmethod
    def acquire(cls, path: Path) -> Producer:
        """The producer of a file; each call is matched by one of `release`.

        Raises MissingFileError, SourceUnavailableError.
        """
        path = path.resolve()
        if not path.is_file():
            raise MissingFileError(f"there is no GenTL producer {path}")
        with cls._lock:
            producer = cls._open.get(path)
            if producer is None:
                producer = cls._open[path] = cls(path)
            producer._users += 1
            return producer

    def release(self) -> None:
        """Give it back; the last user's call unloads it. Never raises."""
        with self._lock:
            self._users -= 1
            if self._users:
                return
            del self._open[self.path]
            for module in (*self._interfaces.values(), self._system, self._library):
                try:
                    module.close()
                except gentl.GenericException:
                    continue  # it is of no use any more, whatever it says

    def cameras(self, timeout_ms: int = SEARCH_MS) -> list[FoundCamera]:
        """Every camera on every interface, as the producer lists them. Raises as registers do."""
        found: list[FoundCamera] = []
        with self._lock, answering(f"looking for cameras of {self.path.name}"):
            self._system.update_interface_info_list(timeout_ms)
            for interface_info in self._system.interface_info_list:
                interface = self._opened(interface_info)
                interface.update_device_info_list(timeout_ms)
                found += [
                    FoundCamera(info, self._describe(interface_info, info))
                    for info in interface.device_info_list
                ]
        return found

    def _opened(self, interface_info: Any) -> Any:
        """Cameras of one interface share its opening too; it lasts as long as the producer's."""
        interface = self._interfaces.get(interface_info.id_)
        if interface is None:
            interface = interface_info.create_interface()
            interface.open()
            self._interfaces[interface_info.id_] = interface
        return interface

    def _describe(self, interface_info: Any, info: Any) -> DeviceInfo:
        return DeviceInfo(
            uri=str(SourceUri("gentl", f"{self.path}#{info.id_}")),
            vendor=text_of(info, "vendor"),
            model=text_of(info, "model"),
            serial=text_of(info, "serial_number"),
            bus=f"GenTL ({text_of(info, 'tl_type')})",
            address=info.id_,
            user_name=text_of(info, "user_defined_name"),
            version=text_of(info, "version"),
            interface=text_of(interface_info, "display_name"),
        )


def text_of(module: Any, attribute: str) -> str:
    """A piece of information that a producer may leave out."""
    try:
        return str(getattr(module, attribute))
    except gentl.GenericException:
        return ""


def installed_producers() -> list[Path]:
    """The `.cti` files that the environment variable names; folders that are gone are passed over."""
    found: list[Path] = []
    for entry in os.environ.get(SEARCH_PATH, "").split(os.pathsep):
        path = Path(entry)
        if not entry:
            continue
        # A folder may not be readable, or the entry may be no path at all.
        with contextlib.suppress(OSError, ValueError):
            candidates = sorted(path.glob("*.cti")) if path.is_dir() else [path]
            found += [file for file in candidates if file.suffix == ".cti" and file.is_file()]
    return list(dict.fromkeys(found))
