"""Features of a camera as attributes and items of a Python object, and its files."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Generic, TypeVar, cast, overload

import numpy as np

from grabbergui.core import file_access
from grabbergui.core.errors import ClosedError, FeatureAccessError, FeatureNotFoundError, UsageError
from grabbergui.core.features import Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.file_access import CameraFile, Written
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import Role
from grabbergui.models.features.number_input import typed_value

Value = TypeVar("Value", float, str, int)

SettingValue = FeatureValue | np.bool_ | np.integer[Any] | np.floating[Any]
"A value that can be written: a plain one, its text, or one of numpy's scalars."


class Setting(Generic[Value]):
    """A camera's setting as an attribute, under whatever name this camera has for it."""

    def __init__(self, role: Role, doc: str) -> None:
        self.role = role
        self.__doc__ = doc

    @overload
    def __get__(self, camera: None, owner: type) -> Setting[Value]: ...
    @overload
    def __get__(self, camera: FeatureAccess, owner: type) -> Value: ...
    def __get__(self, camera: FeatureAccess | None, owner: type) -> Setting[Value] | Value:
        return self if camera is None else cast(Value, camera.read(self.role.names[0]))

    def __set__(self, camera: FeatureAccess, value: SettingValue) -> None:
        camera.write(self.role.names[0], value)


class FeatureAccess:
    """Reads and writes the features of an open grabber; the base of `grabbergui.Camera`.

    Every method takes the camera's own name (`ExposureTime`), its Python spelling (`exposure_time`), or
    SFNC's name where an older camera has another one; selectors in brackets: `Gain[GainSelector=Red]`.
    """

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
        self._spellings: tuple[Category | None, dict[str, str]] = (None, {})

    @property
    def grabber(self) -> FrameGrabber:
        """The grabber underneath. Not part of the stable interface."""
        return self._grabber

    def read(self, name: str) -> FeatureValue:
        """Return a feature's value. IPv4 and MAC addresses and hexadecimal numbers are text.

        Raises FeatureNotFoundError, FeatureAccessError if it cannot be read, TransportError.
        """
        feature = self.feature(name)
        value = feature.spelled(feature.value)
        if value is None:
            raise FeatureAccessError(
                f"{name} is a command; run it with camera.execute('{name}')"
                if feature.kind is FeatureKind.COMMAND
                else f"{name} cannot be read: it {feature.access_problem()}",
                feature.name,
            )
        return value

    def write(self, name: str, value: SettingValue) -> FeatureValue:
        """Write a feature and return what the camera then reports, which it may have rounded.

        A text is read as in the window: `"20ms"`, `"Continuous"`, `"on"`. An automatic mode of the feature is
        switched off first; a stream that locks the feature pauses for a moment. Returns when the camera has
        acknowledged; frames that are exposed with the value come a little later, see `grab`. Raises
        FeatureNotFoundError, FeatureAccessError, FeatureValueError, TransportError.
        """
        feature = self._write(self._key_of(name), value)
        written = feature.spelled(feature.value)
        return _plain(value) if written is None else written

    def _write(self, key: SettingKey, value: SettingValue) -> Feature:
        value = _plain(value)
        if isinstance(value, str):
            value = typed_value(value, self._grabber.read_setting(key))
        result = self._grabber.write_setting(key, value)
        self._keep_trigger |= key.name.startswith("Trigger")
        return result.feature

    def execute(self, name: str) -> None:
        """Run a command feature and wait until the camera has done it."""
        self._grabber.execute_setting(self._key_of(name))

    def feature(self, name: str) -> Feature:
        """Return a feature with its value, range, unit, entries and access as they are now."""
        return self._grabber.read_setting(self._key_of(name))

    def features(self) -> Iterator[Feature]:
        """Every feature as it is now, in the camera's own order. May read hundreds of registers."""
        return iter(self._grabber.features())

    def __getitem__(self, name: str) -> FeatureValue:
        return self.read(name)

    def __setitem__(self, name: str, value: SettingValue) -> None:
        self.write(name, value)

    def __contains__(self, name: object) -> bool:
        try:
            return self._grabber.has_feature(self._key_of(cast(str, name)).name)
        except UsageError:
            return False

    def __getattr__(self, attribute: str) -> Any:
        return self.read(self._name_of_attribute(attribute))

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute.startswith("_") or hasattr(type(self), attribute):
            object.__setattr__(self, attribute, value)
        else:
            self.write(self._name_of_attribute(attribute), value)

    def __dir__(self) -> list[str]:
        with contextlib.suppress(ClosedError):  # debuggers and shells list a closed camera, too
            return sorted({*super().__dir__(), *self._attributes()})
        return sorted(super().__dir__())

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._attributes().values())

    def _key_of(self, name: str) -> SettingKey:
        """Return the setting that a name means, with the camera's own names. Raises UsageError.

        A name that the camera does not have stays as it is; whoever uses it raises FeatureNotFoundError.
        """
        if not isinstance(name, str):
            raise UsageError(f"{name!r} is no feature's name; write it as text, as in camera['ExposureTime']")
        key = SettingKey.parse(name)
        selected = tuple((self._own_name(selector), entry) for selector, entry in key.selected)
        return SettingKey(self._own_name(key.name), selected)

    def _existing_key_of(self, name: str) -> SettingKey:
        """Return the setting that a name means. Raises FeatureNotFoundError, which suggests others."""
        key = self._key_of(name)
        for each in (key.name, *(selector for selector, _ in key.selected)):
            if not self._grabber.has_feature(each):
                self._grabber.feature(each)
        return key

    def _own_name(self, name: str) -> str:
        if self._grabber.has_feature(name):
            return name
        spelling = attribute_name(name)
        role = _ROLES.get(spelling)
        found = self._grabber.role(role) if role is not None else None
        return found or self._attributes().get(spelling, name)

    def _name_of_attribute(self, attribute: str) -> str:
        """Return the feature that an attribute means. Raises AttributeError."""
        if attribute.startswith("_"):
            raise AttributeError(f"a camera has no attribute '{attribute}'")
        name = self._own_name(attribute)
        if not self._grabber.has_feature(name):
            try:
                self._grabber.feature(name)
            except FeatureNotFoundError as error:
                raise AttributeError(str(error)) from None
        return name

    def _attributes(self) -> dict[str, str]:
        """Features by their names in Python's spelling."""
        tree = self._grabber.feature_tree()
        known, attributes = self._spellings
        if known is not tree:
            names = [description.name for description in tree.descriptions()]
            attributes = {attribute_name(name): name for name in reversed(names)}
            self._spellings = tree, attributes
        return attributes


def attribute_name(feature: str) -> str:
    """Return a feature's name in Python's spelling: `GevSCPSPacketSize` is `gev_scps_packet_size`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", feature).lower()


_ROLES: dict[str, Role] = {
    **{attribute_name(role.names[0]): role for role in Role},
    **{name: setting.role for name, setting in vars(FeatureAccess).items() if isinstance(setting, Setting)},
}
"Roles by the names that mean them on every camera, in Python's spelling."


def _plain(value: SettingValue) -> FeatureValue:
    """Return a value in Python's own type."""
    if isinstance(value, int | float | str):  # also numpy.float64, which is a float
        return value
    return value.item() if isinstance(value, np.generic) else str(value)


class CameraFiles:
    """The files in a camera (SFNC FileAccessControl): look-up tables, shading data, user sets, firmware.

    Names are those of FileSelector. Any thread may call; a transfer does not block other calls. Raises
    UsageError for a name that the camera does not list and for a camera without files, `CameraFileError` for
    what the camera refuses, `LocalFileError` for a file on this computer, and TransportError. Remote sources
    list files, and raise FeatureAccessError for all else.
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
        if not isinstance(data, bytes | bytearray | memoryview):
            raise UsageError(f"files.write({name!r}, …): the content is bytes, or a pathlib.Path to a file")
        return file_access.write_file(self._camera.grabber, name, data, replace_firmware=replace_firmware)

    def delete(self, name: str) -> None:
        """Delete a file; firmware is refused."""
        file_access.delete_file(self._camera.grabber, name)
