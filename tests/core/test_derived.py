import numpy as np
import pytest

from grabbergui.core.derived import millimetres, polarisation


def test_coordinates_become_millimetres_and_what_was_not_measured_nan():
    raw = np.array([[0, 10], [20, 65535]], np.uint16)
    found = millimetres(raw, 0.5, 100.0, invalid=0)
    assert found.dtype == np.float32 and np.isnan(found[0, 0])
    assert found[raw != 0].tolist() == [105.0, 110.0, 32867.5]


@pytest.mark.parametrize("angle", [0.0, 30.0, 45.0, 90.0, 120.0, 179.0])
@pytest.mark.parametrize("degree", [0.2, 1.0])
def test_malus_law_gives_degree_and_angle_back(angle, degree):
    """Behind a polariser at p light of an angle and degree has I / 2 × (1 + degree × cos 2(p - angle))."""
    filters = np.array([[90.0, 45.0], [135.0, 0.0]])
    cell = 1000 * (1 + degree * np.cos(np.radians(2 * (filters - angle))))
    found = polarisation(np.pad(np.tile(cell, (3, 4)), ((0, 1), (0, 0))))
    assert found.intensity.shape == (3, 4)
    assert np.allclose(found.intensity, 1000)
    assert np.allclose(found.degree, degree, atol=1e-4)
    assert np.allclose(found.angle, angle, atol=0.01) or np.allclose(found.angle, angle + 180, atol=0.01)


def test_darkness_is_not_polarised():
    assert not polarisation(np.zeros((4, 4), np.uint16)).degree.any()
