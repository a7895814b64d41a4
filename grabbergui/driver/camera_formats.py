"""The pixel formats of one camera: its own names for the codes that the convention does not have."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core import pfnc, vendor_formats
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import PixelFormat
from grabbergui.driver.genapi.node_map import CameraNodeMap

_FORMATS = ("PixelFormat", "ChunkPixelFormat", "ComponentPixelFormat")
"Enumerations whose entries have codes of formats as their values."


class CameraFormats:
    """Gives frames the formats that their camera means. One thread, that of the stream."""

    def __init__(self, nodes: CameraNodeMap, vendor: str) -> None:
        """Read the names in the description; needs no access to the camera."""
        self._vendor = vendor
        self._names: dict[int, str] = {}
        for name in reversed(_FORMATS):
            self._names.update(nodes.entry_numbers(name))
        self._found: dict[int, PixelFormat] = {}

    def of(self, code: int) -> PixelFormat:
        """Return the format of a code in this camera's frames."""
        if code not in self._found:
            self._found[code] = vendor_formats.of_camera(code, self._names.get(code, ""), self._vendor)
        return self._found[code]

    def correct(self, frame: Frame) -> None:
        """Replace the formats of a frame, and of its parts, that are not those of the convention."""
        if _is_foreign(frame.pixel_format):
            frame.pixel_format = self.of(frame.pixel_format.code)
        if any(_is_foreign(part.pixel_format) for part in frame.parts):
            frame.parts = tuple(
                replace(part, pixel_format=self.of(part.pixel_format.code))
                if _is_foreign(part.pixel_format)
                else part
                for part in frame.parts
            )


def _is_foreign(pixel_format: PixelFormat) -> bool:
    # A frame without an image has a format without a code.
    return pixel_format.code != 0 and not pfnc.is_known(pixel_format.code)
