"""GenTL producers, each opened once per process, and their cameras."""

from __future__ import annotations

import logging
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from genicam import gentl

from grabbergui.core.errors import MissingFileError, SourceUnavailableError
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.driver.gentl.errors import answering, reason_of

log = logging.getLogger(__name__)

SEARCH_MS = 1000
"""Default milliseconds for a producer's search of interfaces and cameras."""


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
    """An open producer, shared by its cameras: GenTL allows one opening per process. Any thread."""

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
        """Return the producer of a file. Each call needs a matching `release`.

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
        """Release the producer; the last user's call unloads it. Never raises."""
        with self._lock:
            self._users -= 1
            if self._users:
                return
            del self._open[self.path]
            for module in (*self._interfaces.values(), self._system, self._library):
                try:
                    module.close()
                except gentl.GenericException:
                    continue  # the module is no longer needed

    def cameras(self, timeout_ms: int = SEARCH_MS) -> list[FoundCamera]:
        """Return the cameras on all interfaces, in the producer's order. Raises as registers do."""
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
        """Return an open interface, which its cameras share until the producer is closed."""
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
    """Return a text property, or an empty text if the producer does not provide it."""
    try:
        return str(getattr(module, attribute))
    except gentl.GenericException:
        return ""
