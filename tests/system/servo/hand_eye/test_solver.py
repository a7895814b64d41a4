"""Hand–eye calibration against a simulated truth."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.servo import _hand_eye_scenes as scenes
from grabbergui.calibration import geometry
from grabbergui.core.errors import CalibrationError, UsageError
from grabbergui.servo.hand_eye import hand_eye_file
from grabbergui.servo.hand_eye.measurement import Arrangement, Problem
from grabbergui.servo.hand_eye.proposals import propose
from grabbergui.servo.hand_eye.solver import HandEyeResult, solve


@pytest.mark.parametrize("kind", scenes.KINDS)
def test_the_camera_is_found_despite_joint_offsets(kind):
    seed = scenes.KINDS.index(kind)
    of = scenes.scene(kind, seed=seed)
    result = solve(of.arrangement, scenes.views(of, count=20, seed=seed), scenes.CAMERA)
    true = scenes.observable(of)
    metres, radians = geometry.distance(result.camera, true), geometry.angle_between(result.camera, true)
    assert 1e3 * metres < 1.5
    assert np.degrees(radians) < 0.15
    assert result.rms == pytest.approx(0.5 * np.sqrt(2), rel=0.15)
    sure_metres, sure_radians = result.uncertainty
    assert metres < 4 * sure_metres < 0.006
    assert radians < 4 * sure_radians < np.radians(0.6)


@pytest.mark.parametrize("kind", scenes.KINDS)
def test_derivatives_are_those_of_the_residuals(kind):
    of = scenes.scene(kind)
    problem, view = Problem(of.arrangement, scenes.CAMERA), scenes.views(of, count=1)[0]

    def by_difference(size, residuals):
        steps = np.eye(size) * 1e-6
        return np.column_stack([(residuals(step) - residuals(-step)) / 2e-6 for step in steps])

    parameters = by_difference(
        problem.size, lambda step: problem.residuals(view, problem.changed(of.truth, step))
    )
    assert problem.jacobian(view, of.truth) == pytest.approx(parameters, abs=1e-4)

    def after_moving(step):
        camera, target = np.split(step, [len(view.camera_angles)])
        angles = {"camera_angles": view.camera_angles + camera, "target_angles": view.target_angles + target}
        return problem.residuals(replace(view, **angles), of.truth)

    readings = by_difference(len(view.camera_angles) + len(view.target_angles), after_moving)
    assert problem.by_readings(view, of.truth) == pytest.approx(readings, abs=1e-4)


def test_noisy_readings_increase_the_reported_uncertainty():
    of = scenes.scene("eye in hand")
    result = solve(of.arrangement, scenes.views(of, count=20, reading=0.2), scenes.CAMERA)
    assert 0.1 <= np.degrees(result.reading_spread) <= 0.5
    metres = geometry.distance(result.camera, scenes.observable(of))
    assert metres < 4 * result.uncertainty[0] < 0.02


def test_without_noise_the_offsets_of_the_joints_are_found_too():
    of = scenes.scene("head and hand")
    result = solve(of.arrangement, scenes.views(of, count=15, pixel=0.02), scenes.CAMERA)
    free = of.arrangement.free_offsets()
    for found, true, findable in zip(
        (result.camera_offsets, result.target_offsets),
        (of.truth.camera_offsets, of.truth.target_offsets),
        free,
        strict=True,
    ):
        assert np.degrees(found[findable]) == pytest.approx(np.degrees(true[findable]), abs=0.03)
        assert (found[~findable] == 0).all()


def test_a_view_that_contradicts_the_others_is_left_out():
    of = scenes.scene("eye to hand")
    views = scenes.views(of, count=15)
    views[4] = replace(views[4], pixels=views[4].pixels + 25)
    result = solve(of.arrangement, views, scenes.CAMERA)
    assert [number for number, error in enumerate(result.errors) if np.isnan(error)] == [4]
    assert 1e3 * geometry.distance(result.camera, scenes.observable(of)) < 3


def test_proposed_poses_determine_more_than_random_ones():
    of = scenes.scene("eye in hand")
    chosen = scenes.views(of, count=10, pixel=0.0)
    drawn = scenes.views(of, count=60, pixel=0.0)[50:]
    assert scenes.spread(of, chosen) < 0.7 * scenes.spread(of, drawn)


def test_too_few_views_and_too_little_motion_are_refused():
    of = scenes.scene("eye in head")
    views = scenes.views(of, count=6)
    with pytest.raises(CalibrationError, match="5 views or more, not 4"):
        solve(of.arrangement, views[:4], scenes.CAMERA)
    with pytest.raises(CalibrationError, match="differ too little"):
        solve(of.arrangement, [views[0]] * 6, scenes.CAMERA)


def test_motion_about_one_axis_only_is_refused():
    of = scenes.scene("eye in head")
    views = scenes.views(of, count=6)
    start, pan = views[0].camera_angles, np.array([0.05, 0.0])
    turned = [replace(view, camera_angles=start + number * pan) for number, view in enumerate(views)]
    with pytest.raises(CalibrationError, match="differ too little"):
        solve(of.arrangement, turned, scenes.CAMERA)


def test_an_impossible_arrangement_is_refused():
    with pytest.raises(UsageError, match="nothing moves"):
        Arrangement(None, None)
    of = scenes.scene("eye to hand")
    behind = replace(of.nominal, camera=of.nominal.camera @ np.diag([1.0, -1.0, -1.0, 1.0]))
    with pytest.raises(CalibrationError, match=r"only 0 of 200 poses show the target"):
        propose(of.arrangement, behind, scenes.GRID, scenes.CAMERA, 5, tries=200)


def test_a_result_survives_its_file(tmp_path):
    of = scenes.scene("eye in head")
    result = solve(of.arrangement, scenes.views(of, count=8), scenes.CAMERA)
    file = tmp_path / "teo.hand-eye.yaml"
    hand_eye_file.save(result, file)
    again = hand_eye_file.load(file)
    assert again.camera == pytest.approx(result.camera)
    assert again.camera_offsets == pytest.approx(result.camera_offsets)
    assert again.uncertainty == pytest.approx(result.uncertainty)
    assert again.rms == pytest.approx(result.rms)


BOMB = "a0: &a0 [0, 0]\n" + "".join(f"a{n}: &a{n} [{f'*a{n - 1}, ' * 8}]\n" for n in range(1, 8))
"""Lists of lists of lists by aliases: 4 million numbers in 300 bytes."""


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda text: "[1, 2", "line 1: while parsing a flow sequence, .*expected ','"),
        (lambda text: "7", "has no entries"),
        (lambda text: "", "no hand–eye calibration"),
        (lambda text: text + "a: " + "[" * 2000, "no YAML"),
        (lambda text: text + "# long\n" * 10_000, "too long"),
        (lambda text: text.replace("rms_pixels: ", "rms_pixels: !!timestamp x"), "robot.yaml"),
        (lambda text: text.replace("rms_pixels: ", f"rms_pixels: {'1' * 5000} #"), "rms_pixels"),
        (
            lambda text: text.replace("rms_pixels: ", f"rms_pixels: !!int {'1' * 400} #"),
            "no numbers under rms",
        ),
        (lambda text: BOMB + text.replace("covariance:", "covariance: *a7\nother:"), "no numbers under cov"),
        (lambda text: BOMB + text.replace("method:", "method: *a7\nother:"), "method is no name"),
        (lambda text: text.replace("camera:", "eye:"), "no camera with a translation"),
        (lambda text: text.replace("rms_pixels: ", "rms_pixels: x"), "no numbers under rms_pixels"),
        (lambda text: text.replace("rms_pixels: ", "rms_pixels: .inf #"), "must be one number of finite"),
        (lambda text: text.replace("rotation: [", "rotation: [1.0, "), "rotation must be 4"),
    ],
)
def test_a_file_that_holds_no_result_is_refused(tmp_path, change, complaint):
    file, some = tmp_path / "robot.yaml", HandEyeResult(np.eye(4), np.eye(4), np.zeros(2), np.zeros(0))
    hand_eye_file.save(some, file)
    file.write_text(change(file.read_text()))
    with pytest.raises(UsageError, match=complaint):
        hand_eye_file.load(file)
