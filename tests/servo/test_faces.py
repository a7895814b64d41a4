"""Which face detector is used, and which heads YuNet finds."""

import numpy as np
import pytest

from benchmarks import _heads
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.servo import faces
from grabbergui.servo.config import Config
from grabbergui.servo.faces import CascadeFaceDetector, YuNetFaceDetector, face_detector

CALIBRATION = Calibration.from_field_of_view(1920, 1080, 60)
needs_model = pytest.mark.skipif(faces.installed_model() is None, reason="needs the extra faces")


def test_a_model_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(UsageError, match="there is no face model"):
        face_detector(CALIBRATION, str(tmp_path / "none.onnx"))
    bad = tmp_path / "bad.onnx"
    bad.write_bytes(b"not a network")
    with pytest.raises(UsageError, match="no YuNet model"):
        face_detector(CALIBRATION, str(bad))


def test_a_configuration_names_a_detector_that_exists(tmp_path):
    assert Config.parse("[faces]\ndetector cascade").faces.detector == "cascade"
    with pytest.raises(UsageError, match=r"\[faces\] detector is 'yunet'.*auto, cascade"):
        Config.parse("[faces]\ndetector yunet")


def test_without_the_model_the_cascade_searches(monkeypatch):
    monkeypatch.setattr(faces, "MODEL_PACKAGE", "no_such_package")
    assert faces.installed_model() is None
    assert isinstance(face_detector(CALIBRATION), CascadeFaceDetector)


def test_the_package_of_the_model_is_not_imported(monkeypatch, tmp_path):
    folder = tmp_path / "package_with_a_model"
    folder.mkdir()
    (folder / "__init__.py").write_text("raise RuntimeError('imported')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(faces, "MODEL_PACKAGE", folder.name)
    assert faces.installed_model() is None, "it has no model yet"
    (folder / faces.MODEL_FILE).write_bytes(b"a model")
    assert faces.installed_model() == folder / faces.MODEL_FILE


@needs_model
def test_heads_that_turn_or_stand_in_the_dark_are_found():
    """At 1.2 m with a field of view of 60°; the cascade finds few of these."""
    detector, random = face_detector(CALIBRATION), np.random.default_rng(1)
    assert isinstance(detector, YuNetFaceDetector)
    face, found = _heads.drawn_face(), 0
    cases = [(yaw, pitch, light) for yaw in (-25, 10, 25) for pitch in (0, 12) for light in _heads.LIGHTS]
    for yaw, pitch, light in cases:
        image, (x, y) = _heads.picture(face, yaw, pitch, light, 430, random)
        for each in detector.detect(image):
            left, top, width, height = each.box
            found += abs(left + width / 2 - x) < 150 and abs(top + height / 2 - y) < 150
            assert each.position[2] == pytest.approx(1.2, rel=0.4)
    assert found >= 0.8 * len(cases)


@needs_model
@pytest.mark.parametrize("shape", [(512, 608), (1080, 1920), (2160, 4096), (1, 1), (3, 5000)])
def test_no_image_upsets_it(shape):
    detector, random = face_detector(CALIBRATION), np.random.default_rng(1)
    for grey in (np.zeros(shape, np.uint8), np.full(shape, 255, np.uint8)):
        assert detector.detect(grey) == []
    assert isinstance(detector.detect(random.integers(0, 255, shape, np.uint8)), list)
