"""3D data by the features of SFNC's 3D Scan Control: units, invalid values, points."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

from fakes import ScriptedGrabber
from frames import frame_of
from grabbergui import sources
from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.pfnc import by_name
from grabbergui.core.scan3d import CurrentScan3d, FollowedScan3d, read_scan3d
from grabbergui.core.uri import SourceUri
from patience import PATIENCE, until

DEPTH = Coordinate(0.5, 100.0, 0.0)
C_ONLY = Scan3d(calibrated=True, coordinates=(Coordinate(), Coordinate(), DEPTH))


def test_values_become_millimetres_by_scale_and_offset():
    found = C_ONLY.distances(np.array([[0, 10, 20]], np.uint16), by_name("Coord3D_C16"))
    assert np.isnan(found[0, 0]) and found[0, 1:].tolist() == [105.0, 110.0]
    assert C_ONLY.unit_of(by_name("Coord3D_C16")) == "mm"
    inches = replace(C_ONLY, unit=25.4)
    assert inches.distances(np.array([10], np.uint16), by_name("Coord3D_C16"))[0] == pytest.approx(105 * 25.4)


def test_a_camera_that_reports_no_scale_has_values_without_a_unit():
    found = Scan3d().distances(np.array([0, 7], np.uint16), by_name("Coord3D_C16"))
    assert np.isnan(found[0]) and found[1] == 7
    assert Scan3d().unit_of(by_name("Coord3D_C16")) == ""


def test_zero_is_a_distance_where_the_camera_says_that_all_values_are_valid():
    valid = replace(C_ONLY, coordinates=(Coordinate(), Coordinate(), Coordinate(0.5)))
    assert valid.distances(np.array([0], np.uint16), by_name("Coord3D_C16"))[0] == 0


def test_the_coordinates_of_a_camera_whose_invalid_value_is_nan_can_be_recorded():
    values = {"Scan3dCoordinateScale": 0.5, "Scan3dInvalidDataFlag": True, "Scan3dInvalidDataValue": np.nan}
    camera = ScriptedGrabber(
        Feature(
            name=name,
            kind=FeatureKind.BOOLEAN if value is True else FeatureKind.FLOAT,
            access=AccessMode.READ_ONLY,
            value=value,
        )
        for name, value in values.items()
    )
    scan = read_scan3d(camera)
    assert Scan3d.from_json(scan.as_json()) == scan
    assert scan.coordinates[2].scale == 0.5


def test_a_range_image_and_its_focal_length_give_points():
    scan = replace(C_ONLY, focal_length=200.0, principal_point=(11.0, 20.0))
    frame = frame_of(np.array([[200, 0], [200, 400]], np.uint16), "Coord3D_C16")
    frame.offset_x, frame.offset_y = 10, 20
    points = scan.points(frame)
    assert points.shape == (2, 2, 3) and points.dtype == np.float32
    assert points[0, 0].tolist() == [-1.0, 0.0, 200.0]
    assert np.isnan(points[0, 1]).all(), "a point is valid as a whole or not at all"
    assert points[1, 1].tolist() == [0.0, 1.5, 300.0]


def test_all_three_coordinates_have_scales_of_their_own():
    values = np.array([[[1, 2, 3], [4, 0, 6]]], np.uint16)
    axes = (Coordinate(2.0, -1.0), Coordinate(3.0, 0.0, 0.0), Coordinate(10.0))
    points = Scan3d(calibrated=True, coordinates=axes).points(frame_of(values, "Coord3D_ABC16"))
    assert points[0, 0].tolist() == [1.0, 6.0, 30.0]
    assert np.isnan(points[0, 1]).all()


def test_a_rectified_image_has_its_other_coordinates_in_columns_and_lines():
    axes = (Coordinate(0.2, -1.0), Coordinate(0.4, 5.0), DEPTH)
    scan = Scan3d(calibrated=True, coordinates=axes, output_mode="RectifiedC_Linescan")
    points = scan.points(frame_of(np.full((2, 3), 10, np.uint16), "Coord3D_C16"))
    assert points[1, 2] == pytest.approx([-0.6, 5.4, 105.0])


def test_disparities_become_distances_where_baseline_and_focal_length_are_known():
    disparity = replace(
        C_ONLY, output_mode="DisparityC", coordinates=(*C_ONLY.coordinates[:2], Coordinate(0.5))
    )
    values = np.array([0, 8], np.uint16)
    assert disparity.unit_of(by_name("Coord3D_C16")) == "px"
    assert disparity.distances(values, by_name("Coord3D_C16")).tolist() == [0, 4]
    known = replace(disparity, baseline=60.0, focal_length=500.0)
    assert known.unit_of(by_name("Coord3D_C16")) == "mm"
    found = known.distances(values, by_name("Coord3D_C16"))
    assert np.isnan(found[0]) and found[1] == 60 * 500 / 4


@pytest.mark.parametrize(
    ("scan", "name", "message"),
    [
        (C_ONLY, "Coord3D_C16", "neither Scan3dFocalLength"),
        (replace(C_ONLY, system="Spherical"), "Coord3D_C16", "Spherical coordinate system"),
        (C_ONLY, "Coord3D_A16", "Coord3D_A16 has no distances"),
    ],
)
def test_points_that_cannot_be_computed_are_refused_with_advice(scan, name, message):
    with pytest.raises(PixelFormatError, match=message):
        scan.points(frame_of(np.ones((2, 2), np.uint16), name))


def test_each_coordinate_is_read_under_its_selector_which_is_restored():
    selector = Feature(
        name="Scan3dCoordinateSelector",
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_WRITE,
        value="CoordinateA",
        entries=tuple(EnumEntry(f"Coordinate{axis}") for axis in "ABC"),
    )
    scale = Feature(
        name="Scan3dCoordinateScale",
        kind=FeatureKind.FLOAT,
        access=AccessMode.READ_ONLY,
        value=0.25,
        selectors=(selector.name,),
    )
    grabber = ScriptedGrabber([selector, scale])

    scan = read_scan3d(grabber)
    assert scan.calibrated and [axis.scale for axis in scan.coordinates] == [0.25] * 3
    assert [write[1] for write in grabber.writes if write[0] == selector.name][:2] == [
        "CoordinateB",
        "CoordinateA",
    ]
    assert grabber.known[selector.name].value == "CoordinateA"


def test_the_simulated_camera_reports_its_range():
    grabber = sources.create(SourceUri.parse("sim:"))
    grabber.open()
    try:
        scan = read_scan3d(grabber)
    finally:
        grabber.close()
    assert scan.calibrated and scan.coordinates[2] == Coordinate(0.1, 0.0, 0.0)
    assert (scan.focal_length, scan.principal_point) == (2000.0, (2048.0, 1080.0))
    assert read_scan3d(ScriptedGrabber()) == Scan3d()


def test_a_change_during_the_first_read_is_not_overwritten_by_it(monkeypatch):
    camera = ScriptedGrabber()
    values = iter([Scan3d(), C_ONLY])

    def read(grabber):
        value = next(values)
        if value is not C_ONLY:  # the first read: meanwhile the camera reports another scale
            change.start()
            change.join(0.2)
        return value

    changed = frozenset({"Scan3dCoordinateScale"})
    change = threading.Thread(target=camera.features_changed.emit, args=(changed,))
    monkeypatch.setattr("grabbergui.core.scan3d.read_scan3d", read)
    followed = FollowedScan3d(camera)
    change.join(PATIENCE)
    assert followed.value == C_ONLY
    followed.close()


def test_a_camera_polls_nothing_for_coordinates_that_nobody_asked_for(monkeypatch):
    camera, found = ScriptedGrabber(), [C_ONLY, Scan3d()]
    monkeypatch.setattr("grabbergui.core.scan3d.read_scan3d", lambda grabber: found.pop(0))
    current = CurrentScan3d(camera)
    assert not len(camera.features_changed), "a camera polls its features for listeners"
    assert current.value == C_ONLY == current.value
    camera.features_changed.emit(frozenset({"Scan3dCoordinateScale"}))
    assert current.value == Scan3d() and found == []
    current.close()
    current.close()
    assert not len(camera.features_changed)


def test_a_change_is_followed_while_whoever_reports_it_holds_the_camera(monkeypatch):
    camera = ScriptedGrabber()
    followed = FollowedScan3d(camera)
    reading = threading.Event()

    def read(grabber):
        reading.set()
        with grabber.exclusive():
            return C_ONLY

    monkeypatch.setattr("grabbergui.core.scan3d.read_scan3d", read)
    changed = frozenset({"Scan3dCoordinateScale"})

    def write():
        with camera.exclusive():
            threading.Thread(target=camera.features_changed.emit, args=(changed,), daemon=True).start()
            reading.wait(PATIENCE)
            camera.features_changed.emit(changed)

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    writer.join(PATIENCE)
    assert not writer.is_alive()
    until(lambda: followed.value == C_ONLY)
    followed.close()


def test_units_and_axes_of_a_camera_are_read():
    values = {
        "Scan3dCoordinateScale": 0.5, "Scan3dCoordinateOffset": 2.0, "Scan3dDistanceUnit": "Inch",
        "Scan3dBaseline": 2.0, "Scan3dFocalLength": 500.0, "Scan3dPrincipalPointU": 3.0,
        "Scan3dPrincipalPointV": 4.0, "Scan3dOutputMode": "RectifiedC",
    }  # fmt: skip
    scan = read_scan3d(
        ScriptedGrabber(
            Feature(
                name=name,
                kind=FeatureKind.STRING if isinstance(value, str) else FeatureKind.FLOAT,
                access=AccessMode.READ_ONLY,
                value=value,
            )
            for name, value in values.items()
        )
    )
    assert (scan.unit, scan.baseline, scan.focal_length) == (25.4, 50.8, 500.0)
    assert (scan.principal_point, scan.output_mode) == ((3.0, 4.0), "RectifiedC")
    assert {(axis.scale, axis.offset) for axis in scan.coordinates} == {(0.5, 2.0)}


def test_each_axis_has_its_own_scale():
    scan = Scan3d(True, (Coordinate(2.0, 1.0), Coordinate(3.0, 2.0), Coordinate(0.5, 4.0)))
    every = frame_of(np.array([[[1, 2, 8]]], np.uint16), "Coord3D_ABC16")
    assert scan.points(every)[0, 0].tolist() == [3.0, 8.0, 8.0]
    two = frame_of(np.array([[[1, 8]]], np.uint16), "Coord3D_AC16")
    assert replace(scan, focal_length=4.0).points(two)[0, 0].tolist() == [3.0, 0.0, 8.0]
