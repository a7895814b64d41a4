"""Markers and faces found in images whose truth is known; faces followed from image to image."""

import threading

import cv2
import numpy as np
import pytest

import servo_scene
from benchmarks.servo import _heads
from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection, judged
from grabbergui.calibration.markers import ArucoDetector
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.driver.sim import person
from grabbergui.driver.sim.rendered_scene import at
from grabbergui.servo import face_detectors, face_search
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector, FaceDetection, Sighting
from grabbergui.servo.face_detectors import (
    MODEL_FILE,
    CascadeFaceDetector,
    YuNetFaceDetector,
    face_detector,
    installed_model,
)
from grabbergui.servo.face_search import MISSES, FaceSearch
from patience import until

SQUARE = np.array([[0.0, 0], [100, 0], [100, 100], [0, 100]])


@pytest.mark.parametrize("binning", [4, 2, 1])
@pytest.mark.parametrize(("yaw", "pitch"), [(20, 0), (-35, 15), (10, -40)])
def test_the_pose_of_a_marker_is_true(binning, yaw, pitch):
    of, camera, board = servo_scene.settings(binning), servo_scene.camera(), at(0.7, -0.1, 0.55, yaw, pitch)
    found = ArucoDetector(calibration=servo_scene.calibration(of)).detect(
        servo_scene.image(of, camera, board)
    )
    assert [(marker.marker_id, marker.problem) for marker in found] == [(20, "")]
    true = geometry.inverse(camera) @ board
    assert geometry.distance(found[0].pose, true) < 0.004
    assert np.degrees(geometry.angle_between(found[0].pose, true)) < 1.5


def test_corners_are_found_to_a_fraction_of_a_pixel_in_a_reduced_search():
    of, camera, board = servo_scene.settings(1), servo_scene.camera(), at(0.8, 0.0, 0.5, yaw=25)
    calibration = servo_scene.calibration(of)
    marker = ArucoDetector(calibration=calibration).detect(servo_scene.image(of, camera, board))[0]
    corners = np.array([[-0.05, 0.05, 0, 1], [0.05, 0.05, 0, 1], [0.05, -0.05, 0, 1], [-0.05, -0.05, 0, 1]])
    seen = calibration.matrix @ (geometry.inverse(camera) @ board @ corners.T)[:3]
    assert np.abs(marker.corners - (seen[:2] / seen[2]).T).max() < 0.4


def test_a_marker_seen_edge_on_has_no_pose():
    of, camera = servo_scene.settings(1), servo_scene.camera()
    finder = ArucoDetector(calibration=servo_scene.calibration(of))
    for yaw in (74, 77):
        for marker in finder.detect(servo_scene.image(of, camera, at(0.5, 0.0, 0.5, yaw=yaw))):
            assert marker.pose is None
            assert marker.problem


def test_a_far_marker_seen_head_on_may_be_tilted_either_way():
    """Twenty pixels wide, the two tilts look alike: no pose, or one that is not far off."""
    of, camera = servo_scene.settings(4), servo_scene.camera()
    finder = ArucoDetector(calibration=servo_scene.calibration(of))
    problems = []
    for yaw in range(-14, 15, 2):
        board = at(2.2, 0.02, 0.5, yaw=yaw)
        for marker in finder.detect(servo_scene.image(of, camera, board)):
            problems.append(marker.problem)
            if marker.pose is not None:
                error = geometry.angle_between(marker.pose, geometry.inverse(camera) @ board)
                assert np.degrees(error) < 25
    assert "two poses explain it" in problems


def marker():
    return MarkerDetection(20, SQUARE)


def in_front(z=1.0, tilt=0.4):
    facing = np.diag([1.0, -1.0, -1.0])
    return geometry.pose(facing @ geometry.rotation_from_vector((tilt, 0, 0)), (0, 0, z))


@pytest.mark.parametrize(
    ("poses", "errors", "problem"),
    [
        ([], [], "no pose fits"),
        ([np.full((4, 4), np.nan)], [0.1], "no pose fits"),
        ([in_front()], [float("nan")], "no pose fits"),
        ([in_front(-1.0)], [0.1], "behind the camera"),
        ([in_front()], [40.0], "no square's"),
        ([in_front(tilt=1.4)], [0.1], "edge-on"),
        ([in_front(tilt=0.4), in_front(tilt=-0.4)], [0.2, 0.25], "two poses"),
    ],
)
def test_a_pose_that_cannot_be_trusted_is_not_given(poses, errors, problem):
    result = judged(marker(), poses, errors)
    assert result.pose is None
    assert problem in result.problem


def test_a_pose_that_can_be_trusted_is_given():
    clear = judged(marker(), [in_front(tilt=0.4), in_front(tilt=-0.4)], [0.2, 2.0])
    assert clear.pose is not None
    alike = judged(marker(), [in_front(tilt=0.05), in_front(tilt=-0.05)], [0.2, 0.21])
    assert alike.pose is not None


def test_two_markers_of_one_id_are_none():
    twice = Sighting(0.0, (marker(), marker()))
    assert twice.only(20) is None
    assert twice.duplicates(20)
    assert Sighting(0.0, (marker(),)).only(20) is not None


def test_without_a_calibration_there_are_corners_but_no_pose():
    of = servo_scene.settings(4)
    found = ArucoDetector().detect(servo_scene.image(of, servo_scene.camera(), at(0.7, 0, 0.5)))[0]
    assert found.pose is None
    assert "not calibrated" in found.problem


@pytest.mark.parametrize(("keywords", "complaint"), [({"dictionary": "9X9"}, "4X4_50"), ({"size": 0}, "0 m")])
def test_a_marker_that_cannot_be_is_refused(keywords, complaint):
    with pytest.raises(UsageError, match=complaint):
        ArucoDetector(**keywords)


def test_no_image_upsets_the_finders():
    of = servo_scene.settings(4)
    finder, heads = (
        ArucoDetector(calibration=servo_scene.calibration(of)),
        CascadeFaceDetector(servo_scene.calibration(of)),
    )
    random = np.random.default_rng(1)
    for grey in (
        np.zeros((512, 608), np.uint8),
        np.full((512, 608), 255, np.uint8),
        random.integers(0, 255, (512, 608), np.uint8),
    ):
        assert finder.detect(grey) == []
        assert heads.detect(grey) == []


@pytest.mark.parametrize("binning", [4, 1])
@pytest.mark.parametrize("y", [-0.4, 0.0, 0.3])
def test_the_position_of_a_head_is_true(binning, y):
    of, camera, face = servo_scene.settings(binning), servo_scene.camera(), at(1.2, y, 0.55)
    found = CascadeFaceDetector(servo_scene.calibration(of)).detect(servo_scene.image(of, camera, face=face))
    assert len(found) == 1
    true = (geometry.inverse(camera) @ face)[:3, 3]
    seen = np.array(found[0].position)
    assert np.abs(seen[:2] / seen[2] - true[:2] / true[2]).max() < 0.03
    assert seen[2] == pytest.approx(true[2], rel=0.25)


def test_too_dark_an_image_shows_nothing_and_a_longer_exposure_helps():
    camera, board = servo_scene.camera(), at(0.7, 0, 0.5, yaw=20)
    seen = {}
    for exposure in (20.0, 10_000.0):
        of = servo_scene.settings(4, exposure=exposure)
        grey = servo_scene.image(of, camera, board)
        seen[exposure] = len(ArucoDetector(calibration=servo_scene.calibration(of)).detect(grey))
    assert seen == {20.0: 0, 10_000.0: 1}


def test_heads_are_not_looked_for_while_a_marker_is_seen():
    of, camera = servo_scene.settings(4), servo_scene.camera()
    calibration = servo_scene.calibration(of)
    detector = Detector(ArucoDetector(calibration=calibration), CascadeFaceDetector(calibration))
    both = servo_scene.image(of, camera, at(0.7, -0.1, 0.45, yaw=20), at(1.2, 0.2, 0.65))
    assert [len(found) for found in _found(detector, both)] == [1, 0]
    detector.faces_with_markers = True
    assert [len(found) for found in _found(detector, both)] == [1, 1]


def _found(detector, grey):
    sighting = detector.detect(grey, 0.0)
    return sighting.markers, sighting.faces


@pytest.mark.parametrize("dictionary", ["5X5_100", "DICT_6X6_250", "ARUCO_ORIGINAL"])
def test_markers_of_other_dictionaries_are_found(dictionary):
    name = dictionary if dictionary.startswith("DICT_") else f"DICT_{dictionary}"
    drawn = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name)), 7, 120)
    canvas = np.full((300, 300), 255, np.uint8)
    canvas[90:210, 90:210] = drawn
    assert [marker.marker_id for marker in ArucoDetector(dictionary).detect(canvas)] == [7]


CALIBRATION = Calibration.from_field_of_view(1920, 1080, 60)
needs_model = pytest.mark.skipif(installed_model() is None, reason="needs the extra faces")


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
    monkeypatch.setattr(face_detectors, "MODEL_PACKAGE", "no_such_package")
    assert installed_model() is None
    assert isinstance(face_detector(CALIBRATION), CascadeFaceDetector)


def test_the_package_of_the_model_is_not_imported(monkeypatch, tmp_path):
    folder = tmp_path / "package_with_a_model"
    folder.mkdir()
    (folder / "__init__.py").write_text("raise RuntimeError('imported')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(face_detectors, "MODEL_PACKAGE", folder.name)
    assert installed_model() is None, "it has no model yet"
    (folder / MODEL_FILE).write_bytes(b"a model")
    assert installed_model() == folder / MODEL_FILE


@needs_model
def test_heads_that_turn_or_stand_in_the_dark_are_found():
    """At 1.2 m with a field of view of 60°; the cascade finds few of these."""
    detector, random = face_detector(CALIBRATION), np.random.default_rng(1)
    assert isinstance(detector, YuNetFaceDetector)
    face, found = _heads.drawn_face(), 0
    cases = [(yaw, pitch, light) for yaw in (-25, 10, 25) for pitch in (0, 12) for light in _heads.LIGHTS]
    for yaw, pitch, light in cases:
        image, (x, y) = _heads.scene(face, yaw, pitch, light, 430, random)
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
    monkeypatch.setattr(face_search, "AGAIN_S", 0.0)
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


def test_a_search_that_fails_is_logged_once_and_the_next_one_finds_the_face(made, caplog):
    search, _, everywhere = made
    detect, failures = everywhere.detect, []

    def failing(grey, near=None):
        if len(failures) < 3:
            failures.append(1)
            raise cv2.error("out of memory")
        return detect(grey, near)

    everywhere.detect = failing
    until(lambda: search.detect(GREY) == [] and search._face is not None)
    assert [record.message for record in caplog.records] == ["a search for faces failed: out of memory"]


def test_a_face_near_a_box_is_found_in_the_whole_images_coordinates():
    drawn, image = cv2.resize(person.face(256), (240, 240)), np.full((1080, 1920), 120, np.float32)
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
