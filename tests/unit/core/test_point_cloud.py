"""Point clouds and their PLY files, byte by byte."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from grabbergui.core.point_cloud import PointCloud

POINTS = np.array([[1.5, -2.0, 3.0], [4.0, 5.0, -6.25]], np.float32)


@pytest.mark.parametrize("unit", ["mm", ""])
def test_the_bytes_of_a_file_without_colours(unit: str) -> None:
    comment = unit or "the sensor values, without a unit"
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment coordinates in {comment}\nelement vertex 2\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n"
    )
    expected = header.encode() + struct.pack("<6f", 1.5, -2.0, 3.0, 4.0, 5.0, -6.25)
    assert PointCloud(POINTS, unit=unit).ply() == expected


def test_the_bytes_of_a_file_with_colours() -> None:
    colours = np.array([[1, 2, 3], [255, 128, 0]], np.uint8)
    header, _, body = PointCloud(POINTS, colours).ply().partition(b"end_header\n")
    assert header.endswith(b"float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n")
    assert b"comment coordinates in mm\n" in header
    assert body == struct.pack("<3f3B3f3B", 1.5, -2.0, 3.0, 1, 2, 3, 4.0, 5.0, -6.25, 255, 128, 0)
