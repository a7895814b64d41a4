"""Faces found in images, and followed from image to image."""

import threading

import cv2
import numpy as np
import pytest

from benchmarks import _heads
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.driver.sim import rendered_world as world
from grabbergui.servo import detection
from grabbergui.servo.config import Config
from grabbergui.servo.detection import (
    MISSES,
    CascadeFaceDetector,
    FaceDetection,
    FaceSearch,
    YuNetFaceDetector,
    face_detector,
)
from patience import until

CALIBRATION = Calibration.from_field_of_view(1920, 1080, 60)
needs_model = pytest.mark.skipif(detection.installed_model() is None, reason="needs the extra faces")


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
    monkeypatch.setattr(detection, "MODEL_PACKAGE", "no_such_package")
    assert detection.installed_model() is None
    assert isinstance(face_detector(CALIBRATION), CascadeFaceDetector)


def test_the_package_of_the_model_is_not_imported(monkeypatch, tmp_path):
    folder = tmp_path / "package_with_a_model"
    folder.mkdir()
    (folder / "__init__.py").write_text("raise RuntimeError('imported')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(detection, "MODEL_PACKAGE", folder.name)
    assert detection.installed_model() is None, "it has no model yet"
    (folder / detection.MODEL_FILE).write_bytes(b"a model")
    assert detection.installed_model() == folder / detection.MODEL_FILE


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


GREY = np.zeros((480, 640), np.uint8)


def face(x, width=40):
    return FaceDetection((x, 100, width, width), (0.0, 0.0, 1.0))


class Fake:
    """Finds what it is given, and records where it was asked to look."""

    def __init__(self, *faces):
        self.faces, self.asked, self.threads = list(faces), [], set()

    def detect(self, grey, near=None):
        self.asked.append(near)
        self.threads.add(threading.current_thread().name)
        return list(self.faces)

    def close(self):
        pass


@pytest.fixture
def made(monkeypatch):
    monkeypatch.setattr(detection, "AGAIN_S", 0.0)
    near, everywhere = Fake(), Fake(face(300))
    search = FaceSearch(near, everywhere)
    yield search, near, everywhere
    search.close()


def test_a_whole_image_is_never_searched_on_the_loops_thread(made):
    search, near, everywhere = made
    assert search.detect(GREY) == []
    until(lambda: search.detect(GREY) == [] and near.asked)
    assert everywhere.threads == {"face search"}
    assert everywhere.asked == [None] * len(everywhere.asked)
    assert near.asked[0] == (300, 100, 40, 40)


def test_the_face_is_looked_for_where_it_was_last(made):
    search, near, _ = made
    near.faces = [face(310)]
    until(lambda: search.detect(GREY))
    near.faces = [face(330)]
    assert search.detect(GREY) == [face(330)]
    near.faces = [face(350)]
    search.detect(GREY)
    assert near.asked[-2:] == [(310, 100, 40, 40), (330, 100, 40, 40)]


def test_a_wider_face_elsewhere_is_followed_instead_but_no_equal_one(made):
    search, near, everywhere = made
    near.faces = [face(310)]
    until(lambda: search.detect(GREY))
    count = len(everywhere.asked)
    until(lambda: search.detect(GREY) and len(everywhere.asked) > count + 2)
    assert near.asked[-1][0] == 310
    everywhere.faces = [face(100, 60)]
    until(lambda: search.detect(GREY) and near.asked[-1] == (100, 100, 60, 60))


def test_a_face_that_is_gone_is_given_up(made):
    search, near, everywhere = made
    near.faces = [face(310)]
    until(lambda: search.detect(GREY))
    near.faces, everywhere.faces = [], []
    for _ in range(MISSES):
        assert search.detect(GREY) == [], "it does not count where it is not seen"
    until(lambda: search._found is None and not search._busy)
    asked = len(near.asked)
    search.detect(GREY)
    search.detect(GREY)
    assert len(near.asked) <= asked + 1


def test_a_face_near_a_box_is_found_in_the_whole_images_coordinates():
    drawn, image = cv2.resize(world.face(256), (240, 240)), np.full((1080, 1920), 120, np.float32)
    place = slice(500, 740), slice(1200, 1440)
    image[place] += drawn[..., 3] * (255 * drawn[..., 1] - image[place])
    detector = CascadeFaceDetector(Calibration.from_field_of_view(1920, 1080, 60))
    [whole] = detector.detect(image.astype(np.uint8))
    moved = (whole.box[0] + 40, whole.box[1] - 30, *whole.box[2:])
    [near] = detector.detect(image.astype(np.uint8), moved)
    assert near.box == pytest.approx(whole.box, abs=0.2 * whole.box[2])
    assert near.position[:2] == pytest.approx(whole.position[:2], abs=0.05)


@pytest.mark.parametrize("box", [(-500, -500, 40, 40), (5000, 10, 40, 40), (600, 440, 80, 80), (0, 0, 1, 1)])
def test_a_box_outside_the_image_has_no_face(box):
    assert CascadeFaceDetector(Calibration.from_field_of_view(640, 480, 60)).detect(GREY, box) == []
