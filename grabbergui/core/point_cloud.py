"""Point clouds of frames with Coord3D pixels, and their PLY files (binary, little-endian)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component, ComponentKind
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame

_POSITION = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
_COLOUR = [("red", "u1"), ("green", "u1"), ("blue", "u1")]
_TYPES = {"<f4": "float", "u1": "uchar"}
"Types of a PLY file by numpy's names."


@dataclass(frozen=True, eq=False)
class PointCloud:
    """The measured points of an image, line by line."""

    points: NDArray[np.float32]
    "(n, 3): x y z in millimetres (without a unit if the camera reports no scale), all finite."
    colours: NDArray[np.uint8] | None = None
    "(n, 3) R G B; None without an intensity image of the same size."
    unit: str = "mm"
    "Unit of the points; empty if the camera reports no scale."

    @classmethod
    def of(cls, frame: Frame, scan: Scan3d) -> PointCloud:
        """Compute the points of a frame's first image of coordinates, with colours from its intensity image.

        Raises PixelFormatError if the frame has none, or the camera does not report enough.
        """
        image = required_range_image(frame)
        points = scan.points(image)
        valid = np.isfinite(points[..., 2])
        intensity = next((part for part in frame.components if _has_colours_of(part, image)), None)
        colours = None if intensity is None else intensity.rgb()[valid]
        return cls(points[valid], colours, scan.unit_of(image.pixel_format))

    def ply(self) -> bytes:
        """Encode the points as a PLY file, with colours if there are any."""
        fields = _POSITION + (_COLOUR if self.colours is not None else [])
        vertices = np.empty(len(self.points), fields)
        for index, (name, _) in enumerate(_POSITION):
            vertices[name] = self.points[:, index]
        if self.colours is not None:
            for index, (name, _) in enumerate(_COLOUR):
                vertices[name] = self.colours[:, index]
        header = [
            "ply",
            "format binary_little_endian 1.0",
            f"comment coordinates in {self.unit or 'the sensor values, without a unit'}",
            f"element vertex {len(vertices)}",
            *(f"property {_TYPES[kind]} {name}" for name, kind in fields),
            "end_header",
        ]
        return "\n".join([*header, ""]).encode("ascii") + vertices.tobytes()


def range_image(frame: Frame) -> Component | None:
    """Return the first component of coordinates, if there is any."""
    return next((part for part in frame.components if part.pixel_format.is_coordinate), None)


def required_range_image(frame: Frame) -> Component:
    """Return the first component of coordinates. Raises PixelFormatError if there is none."""
    image = range_image(frame)
    if image is None:
        raise PixelFormatError(
            f"a frame of {frame.pixel_format} has no range image;"
            " switch on ComponentEnable[ComponentSelector=Range] if the camera has it"
        )
    return image


def _has_colours_of(part: Component, image: Component) -> bool:
    same_size = (part.width, part.height) == (image.width, image.height)
    return same_size and part.kind is ComponentKind.INTENSITY and part.pixel_format.convertible
