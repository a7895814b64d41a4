"""Features of a camera as attributes and items of a Python object, its files, and its events.

Events are passed to callbacks that may use the camera.
"""

from __future__ import annotations

import logging
import queue
import re
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar, cast, get_args, overload

from grabbergui.core import file_access
from grabbergui.core.errors import DeviceLostError, FeatureAccessError, FeatureNotFoundError, UsageError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.core.file_access import CameraFile, Written
from grabbergui.core.grabber import ConnectionState, DeviceEvent, FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import Role
from grabbergui.models.features.number_input import typed_value

log = logging.getLogger(__name__)

Value = TypeVar("Value", float, str, int)


class Setting(Generic[Value]):
    """A camera's setting as an attribute, under whatever name this camera has for it."""

    def __init__(self, role: Role, doc: str) -> None:
        self._role = role
        self.__doc__ = doc

    @overload
    def __get__(self, camera: None, owner: type) -> Setting[Value]: ...
    @overload
    def __get__(self, camera: FeatureAccess, owner: type) -> Value: ...
    def __get__(self, camera: FeatureAccess | None, owner: type) -> Setting[Value] | Value:
        return self if camera is None else cast(Value, camera.read(self._name(camera)))

    def __set__(self, camera: FeatureAccess, value: Value) -> None:
        camera.write(self._name(camera), value)

    def _name(self, camera: FeatureAccess) -> str:
        return camera.grabber.role(self._role) or self._role.names[0]


class FeatureAccess:
    """Reads and writes the features of an open grabber; the base of `grabbergui.Camera`."""

    exposure_time = Setting[float](Role.EXPOSURE, "Exposure time, in microseconds on most cameras.")
    gain = Setting[float](Role.GAIN, "Analogue gain, in dB on most cameras.")
    frame_rate = Setting[float](Role.FRAME_RATE, "Frames per second that the camera is asked for.")
    pixel_format = Setting[str](Role.PIXEL_FORMAT, "The PFNC name of the pixel format, as `Mono8`.")
    width = Setting[int](Role.WIDTH, "Width of the region of interest, in pixels.")
    height = Setting[int](Role.HEIGHT, "Height of the region of interest, in pixels.")

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._keep_trigger = False
        "Whether this program has set a trigger, which `start` must then leave on."

    @property
    def grabber(self) -> FrameGrabber:
        """The grabber underneath. Not part of the stable interface."""
        return self._grabber

    def read(self, name: str) -> FeatureValue:
        """Return a feature's value. `name` is the camera's own, with selectors where it has some.

        Raises FeatureNotFoundError, FeatureAccessError if it cannot be read, TransportError.
        """
        feature = self.feature(name)
        if feature.value is None:
            raise FeatureAccessError(
                f"{name} is a command; run it with camera.execute('{name}')"
                if feature.kind is FeatureKind.COMMAND
                else f"{name} cannot be read: it {feature.access_problem()}",
                feature.name,
            )
        return feature.value

    def write(self, name: str, value: FeatureValue) -> FeatureValue:
        """Write a feature and return what the camera then reports, which it may have rounded.

        A text is read as in the window: `"20ms"`, `"Continuous"`, `"on"`. An automatic mode of the feature is
        switched off first; a stream that locks the feature pauses for a moment. Returns when the camera has
        acknowledged; frames that are exposed with the value come a little later, see `grab`. Raises
        FeatureNotFoundError, FeatureAccessError, FeatureValueError, TransportError.
        """
        key = SettingKey.parse(name)
        if isinstance(value, str):
            value = typed_value(value, self._grabber.read_setting(key))
        if not isinstance(value, int | float | str):
            value = cast(FeatureValue, value.item() if hasattr(value, "item") else str(value))
        result = self._grabber.write_setting(key, value)
        self._keep_trigger |= key.name.startswith("Trigger")
        return value if result.feature.value is None else result.feature.value

    def execute(self, name: str) -> None:
        """Run a command feature and wait until the camera has done it."""
        self._grabber.execute_setting(SettingKey.parse(name))

    def feature(self, name: str) -> Feature:
        """Return a feature with its value, range, unit, entries and access as they are now."""
        return self._grabber.read_setting(SettingKey.parse(name))

    def features(self) -> Iterator[Feature]:
        """Every feature as it is now, in the camera's own order. May read hundreds of registers."""
        return iter(self._grabber.features())

    def __getitem__(self, name: str) -> FeatureValue:
        return self.read(name)

    def __setitem__(self, name: str, value: FeatureValue) -> None:
        self.write(name, value)

    def __contains__(self, name: str) -> bool:
        return self._grabber.has_feature(SettingKey.parse(name).name)

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("_"):
            raise AttributeError(f"a camera has no attribute '{attribute}'")
        return self.read(self._feature_name(attribute))

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute.startswith("_") or hasattr(type(self), attribute):
            object.__setattr__(self, attribute, value)
        else:
            self.write(self._feature_name(attribute), value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._attributes()})

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._attributes().values())

    def _feature_name(self, attribute: str) -> str:
        names = self._attributes()
        if attribute in names:
            return names[attribute]
        name = "".join(part.capitalize() for part in attribute.split("_"))
        problem = f"a camera has no attribute '{attribute}'; did you mean {attribute_name(name)}?"
        try:
            self._grabber.feature(name)
        except FeatureNotFoundError as error:
            problem = str(error)
        raise AttributeError(problem)

    def _attributes(self) -> dict[str, str]:
        """Features by their names in Python's spelling."""
        names = [description.name for description in self._grabber.feature_tree().descriptions()]
        return {attribute_name(name): name for name in reversed(names)}

    def _name_of(self, name: str) -> str:
        """A keyword's feature: `ExposureTime` or `exposure_time`."""
        if self._grabber.has_feature(name):
            return name
        role = next((role for role in Role if attribute_name(role.names[0]) == name), None)
        found = self._grabber.role(role) if role is not None else None
        return found or self._attributes().get(name, name)


def attribute_name(feature: str) -> str:
    """Return a feature's name in Python's spelling: `GevSCPSPacketSize` is `gev_scps_packet_size`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", feature).lower()


class CameraFiles:
    """The files in a camera (SFNC FileAccessControl): look-up tables, shading data, user sets, firmware.

    Names are those of FileSelector. Any thread may call; a transfer does not block other calls. Raises
    UsageError for a name that the camera does not list and for a camera without files, `CameraFileError` for
    what the camera refuses, and TransportError. Remote sources list files, and raise FeatureAccessError for
    all else.
    """

    def __init__(self, camera: FeatureAccess) -> None:
        self._camera = camera  # open as long as its files are used

    def list(self) -> tuple[CameraFile, ...]:
        """Return the files with `name`, `size` in bytes, `modes`, and the maker's `details`."""
        return tuple(file_access.list_files(self._camera.grabber))

    def read(self, name: str) -> bytes:
        """Return a file's bytes."""
        return file_access.read_file(self._camera.grabber, name)

    def write(self, name: str, content: bytes | Path, *, replace_firmware: bool = False) -> Written:
        """Replace a file by bytes, or by a file on this computer, and read it back.

        An upload that ends early cannot be resumed: write the whole file again. Firmware is refused without
        `replace_firmware`: a wrong file, or a power cut meanwhile, may leave the camera useless.
        """
        data = file_access.content_of(content) if isinstance(content, Path) else content
        return file_access.write_file(self._camera.grabber, name, data, replace_firmware=replace_firmware)

    def delete(self, name: str) -> None:
        """Delete a file; firmware is refused."""
        file_access.delete_file(self._camera.grabber, name)


Occasion = Literal["change", "event", "lost", "back", "notice"]
MOST_WAITING = 10_000
"Most occasions that wait for slow callbacks; further events and changes are dropped."


class Callbacks:
    """Passes a grabber's signals to callbacks, on a thread that starts with the first callback."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._by_occasion: dict[str, list[Callable[[Any], object]]] = {}
        self._waiting: queue.SimpleQueue[tuple[str, Any] | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._closed = False
        self._lost = False
        self._dropped = False

    def add(self, occasion: Occasion, callback: Callable[[Any], object]) -> Callable[[], None]:
        """Call `callback` on an occasion; the returned function ends that.

        Raises UsageError, DeviceLostError after `close`.
        """
        if occasion not in get_args(Occasion):
            raise UsageError(f"on({occasion!r}): there are {', '.join(get_args(Occasion))}")
        if self._closed:
            raise DeviceLostError(f"on({occasion!r}): {self._grabber.info.title} is closed")
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="camera callbacks", daemon=True)
            self._thread.start()
            self._grabber.features_changed.connect(self._on_features_changed)
            self._grabber.event_received.connect(self._on_event)
            self._grabber.connection_changed.connect(self._on_connection_changed)
            self._grabber.noticed.connect(self._on_noticed)
        callbacks = self._by_occasion.setdefault(occasion, [])
        callbacks.append(callback)
        return lambda: callbacks.remove(callback) if callback in callbacks else None

    def close(self) -> None:
        """End all callbacks; wait for one that runs, unless it is the caller."""
        self._closed = True
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._grabber.features_changed.disconnect(self._on_features_changed)
        self._grabber.event_received.disconnect(self._on_event)
        self._grabber.connection_changed.disconnect(self._on_connection_changed)
        self._grabber.noticed.disconnect(self._on_noticed)
        self._by_occasion.clear()
        self._waiting.put(None)
        if thread is not threading.current_thread():
            thread.join()

    def _on_features_changed(self, names: frozenset[str]) -> None:
        self._put_if_room("change", names)

    def _on_event(self, event: DeviceEvent) -> None:
        self._put_if_room("event", event)

    def _put_if_room(self, occasion: Occasion, what: object) -> None:
        if self._waiting.qsize() < MOST_WAITING:
            self._waiting.put((occasion, what))
        elif not self._dropped:
            self._dropped = True
            log.warning("%s: the callbacks are too slow, so events are dropped", self._grabber.info.title)

    def _on_noticed(self, text: str) -> None:
        self._waiting.put(("notice", text))

    def _on_connection_changed(self, state: ConnectionState, why: str) -> None:
        if state is ConnectionState.LOST and not self._lost:
            self._lost = True
            self._waiting.put(("lost", why))
        elif state is ConnectionState.OPEN and self._lost:
            self._lost = False
            self._waiting.put(("back", why))

    def _run(self) -> None:
        while (happened := self._waiting.get()) is not None:
            occasion, what = happened
            for callback in tuple(self._by_occasion.get(occasion, ())):
                try:
                    callback(what)
                except Exception:
                    log.exception("a callback for %r failed", occasion)
