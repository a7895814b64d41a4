"""Calibrations for poses and servoing: chosen by the user, followed while the camera's settings change."""

import numpy as np
import pytest

from fakes import ScriptedGrabber
from grabbergui.calibration.calibration_choice import CalibrationChoice, CalibrationWatch
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name

WHOLE = Calibration.from_field_of_view(640, 480)


def frame(width=640, height=480, x=0):
    return Frame(np.zeros(1, np.uint8), width, height, by_name("Mono8"), offset_x=x)


class Camera(ScriptedGrabber):
    """One that reports its calibration with its images, as a ROS 2 topic does."""

    own = None

    def calibration(self):
        return self.own


def camera(**features):
    return Camera(
        Feature(name=name, kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=value)
        for name, value in features.items()
    )


def test_other_binning_region_or_size_may_be_another_calibration():
    source = camera(WidthMax=640, HeightMax=480, BinningHorizontal=1, BinningVertical=1, Gain=1)
    watch = CalibrationWatch(source)
    assert watch.another(frame())
    assert not watch.another(frame())
    source.set("Gain", 2)
    assert not watch.another(frame())
    source.set("BinningHorizontal", 2)
    assert watch.another(frame()), "an image of before"
    assert watch.another(frame(320)) and not watch.another(frame(320))
    assert watch.another(frame(320, x=16)) and not watch.another(frame(320, x=16))
    watch.close()
    source.set("BinningHorizontal", 4)
    assert watch.another(frame(320, x=16)), "begins again"


def test_the_calibration_that_the_source_reports_is_followed():
    source = camera()
    choice, watch = CalibrationChoice.reported(source, WHOLE), CalibrationWatch(source)
    assert choice(640, 480) is WHOLE and watch.another(frame())
    assert choice(320, 240).matrix[0, 0] == pytest.approx(WHOLE.matrix[0, 0] / 2)
    source.own = WHOLE.cut_out(100, 50, 200, 100)
    assert watch.another(frame(200, 100)) and not watch.another(frame(200, 100))
    assert choice(200, 100) is source.own


def test_a_camera_that_reports_no_geometry_is_not_followed_into_another_region():
    watch = CalibrationWatch(camera())
    assert watch.another(frame())
    assert not watch.another(frame(200, 100))


def test_a_fisheye_lens_that_a_source_reports_is_refused():
    fisheye = Calibration(640, 480, WHOLE.matrix, np.zeros(4))
    with pytest.raises(UsageError, match="fisheye"):
        CalibrationChoice.reported(camera(), fisheye)
