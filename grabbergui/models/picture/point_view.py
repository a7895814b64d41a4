"""A point cloud as an image: seen from any side, the nearest point of each pixel in its colour."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pixels import DisplayImage
from grabbergui.core.point_cloud import PointCloud
from grabbergui.core.region import Region
from grabbergui.models.picture.quantities import ColourScale

MOST_POINTS = 150_000
"Of a cloud; of a larger one every second, third … is shown."
BACKGROUND = 34
"Grey behind the points."
_FAR = 2.2
"Distance of the eye from the middle of the cloud, in radii of it."


@dataclass(frozen=True)
class Viewpoint:
    """Viewpoint on the cloud; initially the camera."""

    yaw: float = 0.0
    "Degrees to the right."
    pitch: float = 0.0
    "Degrees up."
    zoom: float = 1.0

    def turned(self, right: float, up: float) -> Viewpoint:
        """Return the viewpoint turned by degrees; it cannot turn over."""
        return replace(self, yaw=(self.yaw + right) % 360, pitch=min(max(self.pitch + up, -89.0), 89.0))

    def zoomed(self, factor: float) -> Viewpoint:
        """Return the viewpoint nearer or farther."""
        return replace(self, zoom=min(max(self.zoom * factor, 0.1), 20.0))

    def rotation(self) -> NDArray[np.float32]:
        """Return the rotation from the camera's axes to the view's, (3, 3)."""
        yaw, pitch = np.radians([self.yaw, self.pitch])
        around_y = [[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]]
        around_x = [[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]]
        return (np.array(around_x) @ np.array(around_y)).astype(np.float32)


def draw(cloud: PointCloud, view: Viewpoint, size: tuple[int, int]) -> DisplayImage:
    """Draw the points on (width, height) pixels, in their own colours or by their z.

    The middle of the cloud, by its median, stays in the middle of the image. Any thread.
    """
    width, height = size
    picture = np.full((height * width, 3), BACKGROUND, np.uint8)
    every = max(1, -(-len(cloud.points) // MOST_POINTS))
    points = cloud.points[::every]
    if len(points):
        middle = np.median(points, axis=0)
        apart = points - middle
        radius = max(float(np.percentile(np.abs(apart), 98)), 1e-6)
        seen = apart @ view.rotation().T / np.float32(radius)
        depth = seen[:, 2] + np.float32(_FAR)
        ahead = depth > 0.05
        factor = np.float32(min(width, height) * 0.5 * _FAR * 0.8 * view.zoom) / np.where(ahead, depth, 1)
        column = (seen[:, 0] * factor + width / 2).astype(np.int64)
        line = (seen[:, 1] * factor + height / 2).astype(np.int64)
        shown = ahead & (column >= 0) & (column < width) & (line >= 0) & (line < height)
        # The farthest first: of several points on a pixel the last one stays.
        order = np.flatnonzero(shown)[np.argsort(-depth[shown], kind="stable")]
        picture[line[order] * width + column[order]] = _colours(cloud, points, every)[order]
    return DisplayImage(picture.reshape(height, width, 3), Region(0, 0, width, height))


def _colours(cloud: PointCloud, points: NDArray[np.float32], every: int) -> NDArray[np.uint8]:
    if cloud.colours is not None:
        return cloud.colours[::every]
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    place = np.clip((points[:, 2] - low) / max(high - low, 1e-6) * 255, 0, 255).astype(np.uint8)
    return np.asarray(ColourScale(low, high, "", "Turbo").colours[place], np.uint8)
