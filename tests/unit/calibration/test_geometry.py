import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks._viewpoint import looking_at
from every_case import every_case
from grabbergui.calibration import geometry

components = st.floats(-3, 3, allow_nan=False)
vectors = st.tuples(components, components, components)


@given(vectors)
def test_rotation_vectors_survive(vector):
    rotation = geometry.rotation_from_vector(vector)
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-9)
    again = geometry.rotation_from_vector(geometry.vector_from_rotation(rotation))
    assert again == pytest.approx(rotation, abs=1e-6)


@every_case("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8), (-0.48, 0.6, 0.64)])
@every_case("angle", [0.0, 1e-9, 1e-4, 1.0, math.pi - 1e-9, math.pi])
def test_every_angle_from_none_to_half_a_turn(axis, angle):
    vector = np.array(axis) * angle
    back = geometry.vector_from_rotation(geometry.rotation_from_vector(vector))
    assert np.linalg.norm(back) == pytest.approx(angle, abs=1e-6)
    assert min(np.abs(back - vector).max(), np.abs(back + vector).max()) < 1e-6


@given(vectors, vectors, vectors, vectors)
def test_a_twist_leads_from_one_pose_to_the_other(p, r, q, s):
    start = geometry.pose(geometry.rotation_from_vector(r), p)
    end = geometry.pose(geometry.rotation_from_vector(s), q)
    assert geometry.add_delta(start, geometry.diff(start, end)) == pytest.approx(end, abs=1e-5)


def test_diff_is_along_the_base_s_axes():
    """Worked by hand: turned by 90° about z, then by 0.1 rad about its own x, which is the base's y."""
    start = geometry.pose(geometry.rotation_from_vector((0, 0, math.pi / 2)), (1, 2, 3))
    end = start @ geometry.pose(geometry.rotation_from_vector((0.1, 0, 0)), (0, 0.5, 0))
    assert geometry.diff(start, end) == pytest.approx([-0.5, 0, 0, 0, 0.1, 0], abs=1e-12)


def test_a_camera_that_looks_at_a_point_has_it_straight_ahead():
    camera = looking_at((0.1, -0.2, 0.7), (1.0, 0.5, 0.2))
    assert geometry.is_pose(camera)
    seen = geometry.inverse(camera) @ (1.0, 0.5, 0.2, 1.0)
    assert seen[:2] == pytest.approx([0, 0], abs=1e-12)
    assert seen[2] > 0
    assert camera[2, 1] < 0  # its down is the world's down


@pytest.mark.parametrize(
    "matrix",
    [np.full((4, 4), np.nan), np.eye(3), np.diag([1.0, 1, -1, 1]), 2 * np.eye(4), np.full((4, 4), np.inf)],
)
def test_a_matrix_that_is_no_pose_is_recognised(matrix):
    assert not geometry.is_pose(matrix)


def test_poses_as_the_cartesian_controller_writes_them():
    values = [0.3, -0.2, 0.5, 0.1, -0.7, 1.1]
    assert geometry.vector_from_pose(geometry.pose_from_vector(values)) == pytest.approx(values)
