"""Point clouds as PLY, and snapshots of frames with several components."""

import cv2
import numpy as np
import pytest

from grabbergui.core.component import Component, ComponentKind, PayloadType
from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import by_name
from grabbergui.core.point_cloud import PointCloud
from grabbergui.recording import snapshot

INFO = DeviceInfo("gige:GV01", vendor="Acme", model="Depth", serial="GV01")
SCAN = Scan3d(True, (Coordinate(), Coordinate(), Coordinate(0.5, 0.0, 0.0)), focal_length=100.0)
DEPTH = np.array([[200, 0, 400], [200, 200, 0]], np.uint16)


def bytes_of(array):
    return array.copy().view(np.uint8).reshape(-1)


def frame(*, grey=True):
    parts = [Component(bytes_of(DEPTH), 3, 2, by_name("Coord3D_C16"), ComponentKind.RANGE)]
    if grey:
        image = np.arange(6, dtype=np.uint8)
        parts.insert(0, Component(image, 3, 2, by_name("Mono8")))
        confidence = Component(
            np.full(6, 9, np.uint8), 3, 2, by_name("Confidence8"), ComponentKind.CONFIDENCE
        )
        parts += [confidence, confidence.detached()]
    own = parts[0]
    kind = PayloadType.MULTI_PART
    return Frame(own.data, 3, 2, own.pixel_format, 7, payload_type=kind, parts=tuple(parts))


def read_ply(content):
    """As Stanford's description of the format has it."""
    header, body = content.split(b"end_header\n", 1)
    lines = header.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    kinds = {"float": "<f4", "uchar": "u1"}
    fields = [(name, kinds[kind]) for _, kind, name in map(str.split, filter(_is_property, lines))]
    vertices = np.frombuffer(body, fields)
    assert len(vertices) == count
    return vertices


def _is_property(line):
    return line.startswith("property")


def test_the_measured_points_and_their_brightness_are_in_the_file():
    vertices = read_ply(PointCloud.of(frame(), SCAN).ply())
    assert vertices.dtype.names == ("x", "y", "z", "red", "green", "blue")
    assert vertices["z"].tolist() == [100.0, 200.0, 100.0, 100.0]
    assert vertices["x"].tolist() == [0.0, 4.0, 0.0, 1.0]
    assert vertices["y"].tolist() == [0.0, 0.0, 1.0, 1.0]
    assert vertices["green"].tolist() == [0, 2, 3, 4]


def test_without_an_intensity_image_points_have_no_colours():
    assert read_ply(PointCloud.of(frame(grey=False), SCAN).ply()).dtype.names == ("x", "y", "z")


def test_a_scene_that_was_not_measured_is_a_file_without_points():
    empty = frame(grey=False)
    empty.parts[0].data[:] = 0
    assert len(read_ply(PointCloud.of(empty, SCAN).ply())) == 0


def test_a_frame_without_a_range_image_is_refused_with_advice():
    with pytest.raises(PixelFormatError, match="Mono8 has no range image; switch on ComponentEnable"):
        PointCloud.of(Frame(np.zeros(6, np.uint8), 3, 2, by_name("Mono8")), SCAN)


def test_a_snapshot_has_a_file_for_each_component_and_the_ranges_raw_values(tmp_path):
    path = snapshot.save(frame(), tmp_path, INFO, 0.0)
    names = sorted(file.name.removeprefix(path.stem) for file in tmp_path.iterdir())
    assert names == [".png", "_confidence.png", "_confidence_2.png", "_range.tiff"]
    saved = cv2.imread(str(path.with_name(f"{path.stem}_range.tiff")), cv2.IMREAD_UNCHANGED)
    assert saved.dtype == np.uint16 and np.array_equal(saved, DEPTH)


def test_a_point_cloud_is_named_as_a_snapshot(tmp_path):
    path = snapshot.save_points(frame(), tmp_path / "new", INFO, SCAN, 0.0)
    assert path.suffix == ".ply" and len(read_ply(path.read_bytes())) == 4
    assert snapshot.save_points(frame(), tmp_path / "new", INFO, SCAN, 0.0) != path


@pytest.mark.parametrize(("name", "dtype"), [("Coord3D_ABC16", np.uint16), ("Coord3D_ABC32f", np.float32)])
def test_points_of_three_coordinates_become_a_tiff_in_their_order(tmp_path, name, dtype):
    points = np.arange(18).reshape(2, 3, 3).astype(dtype)
    path = snapshot.save(Frame(bytes_of(points), 3, 2, by_name(name)), tmp_path, INFO, 0.0)
    assert path.suffix == ".tiff"
    saved = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(saved[..., ::-1], points), "OpenCV reads the file's first channel as its last"
