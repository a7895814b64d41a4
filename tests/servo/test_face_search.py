"""A face is followed near its last place; whole images are searched beside the loop."""

import threading

import cv2
import numpy as np
import pytest

from grabbergui.core.calibration import Calibration
from grabbergui.driver.sim.rendered import world
from grabbergui.servo import faces as faces_module
from grabbergui.servo.detection import FaceDetection
from grabbergui.servo.faces import MISSES, CascadeFaceDetector, FaceSearch
from patience import until

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
    monkeypatch.setattr(faces_module, "AGAIN_S", 0.0)
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
