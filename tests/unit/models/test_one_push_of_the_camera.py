"""A camera that regulates itself once, when it is asked to."""

import pytest

from grabbergui.core.sfnc import Role
from grabbergui.models.change_tracking import revert
from grabbergui.models.one_push import has_once, let_camera
from grabbergui.models.undo_steps import Direction


def test_the_simulated_cameras_own_once(stage_on_sim):
    s = stage_on_sim("pixel_format=RGB8&exposure=100")
    assert has_once(s.grabber, Role.EXPOSURE) and has_once(s.grabber, Role.BALANCE_RATIO)
    before = s.light(None).mean
    reported = s.run(lambda bench: let_camera(bench, Role.EXPOSURE))
    assert reported.startswith("Exposure set by the camera: ") and reported.endswith(("µs", "ms")), s.failures
    assert s.value("ExposureAuto") == "Off"
    assert s.light(None).mean > before + 0.1
    assert revert(s.tracked_grabber, Direction.UNDO) == []
    assert s.value("ExposureTime") == pytest.approx(100)


def test_a_camera_without_automatic_has_no_once(stage):
    s = stage()
    assert not has_once(s.grabber, Role.EXPOSURE)
    s.run(lambda bench: let_camera(bench, Role.EXPOSURE))
    assert "does not regulate" in s.failures[0]
