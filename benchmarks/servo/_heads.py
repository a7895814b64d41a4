"""Renders turned and lit heads for face detection: a photograph or drawing of a face on an ellipsoid."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.markers import Grey
from grabbergui.driver.sim import person

POSES = tuple(itertools.product((-40, -25, -10, 10, 25, 40), (-25, -12, 0, 12, 25)))
"Yaw and pitch of the heads, degrees."
HEAD_PART = 0.77
"Height of the head as a part of its square."


@dataclass(frozen=True)
class Light:
    """Direction (x right, y down, z away from the camera) and strength of the light, and ambient light."""

    name: str
    direction: tuple[float, float, float]
    strength: float
    ambient: float
    room: float
    "Brightness of the background."


LIGHTS = (
    Light("from the front", (0, 0, -1), 0.6, 0.5, 1.0),
    Light("from the side", (-1, -0.4, -0.5), 0.9, 0.25, 0.8),
    Light("dim, from above", (0.3, -1, -0.6), 0.3, 0.12, 0.35),
)


@dataclass(frozen=True, eq=False)
class Face:
    """A face from the front, and the ellipsoid that it is laid on."""

    name: str
    image: NDArray[np.float32]
    "Grey, 0 to 255."
    centre: tuple[float, float]
    radii: tuple[float, float, float]
    "Pixels: half of the head's width, height and depth."


def drawn_face() -> Face:
    """Return the face of the simulated person."""
    return Face("drawn", 255 * person.face(512)[..., 1].astype(np.float32), (256, 230), (150, 215, 190))


def photographed_faces(folder: Path) -> Iterator[Face]:
    """Return the largest face of each photograph in a folder, as YuNet's model, if installed, finds it."""
    from grabbergui.servo.face_detectors import installed_model

    model = installed_model()
    if model is None:
        return
    for file in sorted(folder.iterdir()):
        image = cv2.imread(str(file))
        if image is None:
            continue
        scale = 512 / max(image.shape[:2])
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        network = cv2.FaceDetectorYN.create(str(model), "", (image.shape[1], image.shape[0]), 0.7)
        found = network.detect(image)[1]
        if found is not None:
            x, y, width, height = (float(value) for value in max(found, key=lambda box: box[2])[:4])
            grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.float32)
            centre = x + width / 2, y + 0.42 * height
            yield Face(file.stem, grey, centre, (0.6 * width, 0.72 * height, 0.7 * width))


def head(face: Face, yaw: float, pitch: float, light: Light, side: int) -> tuple[Grey, NDArray[np.bool_]]:
    """Return a square of `side` pixels with a head, and the mask of the head's pixels.

    Each pixel's line of sight is intersected with the turned ellipsoid. The intersection determines the
    pixel of the face and its illumination (Lambert).
    """
    radii = np.array(face.radii)
    across = (np.arange(side) - side / 2 + 0.5) * 2 * radii[1] / (HEAD_PART * side)
    x, y = np.meshgrid(across, across)
    turned = geometry.rotation_from_vector((0, np.radians(yaw), 0)) @ geometry.rotation_from_vector(
        (np.radians(pitch), 0, 0)
    )
    form = turned @ np.diag(radii**-2.0) @ turned.T
    slope = form[0, 2] * x + form[1, 2] * y
    rest = form[0, 0] * x * x + 2 * form[0, 1] * x * y + form[1, 1] * y * y - 1
    under = slope * slope - form[2, 2] * rest
    z = (-slope - np.sqrt(np.maximum(under, 0))) / form[2, 2]
    on_head = np.dstack((x, y, z)) @ turned
    normal = (on_head / radii**2) @ turned.T
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    skin = cv2.remap(
        face.image,
        (on_head[..., 0] + face.centre[0]).astype(np.float32),
        (on_head[..., 1] + face.centre[1]).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    hair = on_head[..., 2] > -0.15 * radii[2]
    direction = np.array(light.direction) / np.linalg.norm(light.direction)
    shade = light.ambient + light.strength * np.maximum(normal @ direction, 0)
    shown = np.clip(np.where(hair, 40, skin) * shade, 0, 255)
    return shown.astype(np.uint8), under > 0


def scene(
    face: Face, yaw: float, pitch: float, light: Light, side: int, random: np.random.Generator
) -> tuple[Grey, tuple[float, float]]:
    """Return a noisy 1080p image of a head at a random place, and the middle of the head."""
    width, height = 1920, 1080
    image = cv2.resize(random.integers(60, 190, (24, 32), np.uint8), (width, height)) * light.room
    shown, seen = head(face, yaw, pitch, light, side)
    left, top = int(random.integers(0, width - side)), int(random.integers(0, height - side))
    image[top : top + side, left : left + side][seen] = shown[seen]
    noisy = cv2.GaussianBlur(image, (0, 0), 0.8) + random.normal(0, 3, image.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8), (left + side / 2, top + side / 2)
