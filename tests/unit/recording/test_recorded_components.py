"""Frames with several components are recorded whole by MCAP, and played back; other kinds keep the first."""

import struct

import numpy as np
import pytest
from mcap.reader import make_reader

from frames import frame_of
from grabbergui import sources
from grabbergui.core.component import Component, ComponentKind, PayloadType
from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import by_name
from grabbergui.core.scan3d import read_scan3d
from grabbergui.core.uri import SourceUri
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import open_recording
from grabbergui.recording.recorder import RecordingLimits, create_recorder, create_writer
from patience import PATIENCE

INFO = DeviceInfo("sim:", model="M")
SCAN = Scan3d(True, (Coordinate(), Coordinate(), Coordinate(0.1, 2.0, 0.0)), focal_length=900.0)


def part(pixels, pixel_format, kind, **more):
    data = pixels.copy().view(np.uint8).reshape(-1)
    return Component(data, pixels.shape[1], pixels.shape[0], by_name(pixel_format), kind, **more)


def frame(number, *, range_first=False):
    random = np.random.default_rng(number)
    own = part(random.integers(0, 256, (6, 8), np.uint8), "Mono8", ComponentKind.INTENSITY)
    parts = [
        part(
            random.integers(0, 9999, (3, 4), np.uint16),
            "Coord3D_C16",
            ComponentKind.RANGE,
            source=2,
            region=1,
        ),
        part(random.random((6, 8, 3), np.float32), "Coord3D_ABC32f", ComponentKind.RANGE, purpose=3),
        part(random.integers(0, 256, (6, 8), np.uint8), "Confidence8", ComponentKind.CONFIDENCE),
    ]
    parts.insert(1 if range_first else 0, own)
    moment = 10**18 + number * 10**7
    kind = PayloadType.MULTI_PART
    return Frame(
        own.data, 8, 6, own.pixel_format, number, received_ns=moment, payload_type=kind, parts=tuple(parts)
    )


@pytest.mark.parametrize("range_first", [False, True])
def test_every_component_is_played_as_it_was_recorded(tmp_path, range_first):
    path = tmp_path / "x.mcap"
    writer = create_writer(RecordingKind.MCAP, path, INFO, scan=SCAN)
    sent = [frame(number, range_first=range_first) for number in range(1, 4)]
    for one in sent:
        writer.write(one)
    writer.close()

    recording = open_recording(path)
    try:
        assert len(recording) == 3 and recording.scan == SCAN
        for index, one in enumerate(sent):
            played = recording.frame(index, 5)
            assert np.array_equal(played.raw(), one.raw()) and played.frame_id == one.frame_id
            assert len(played.components) == 4
            for found, original in zip(played.components, one.components, strict=True):
                assert np.array_equal(found.raw(), original.raw())
                for name in ("kind", "source", "region", "purpose", "pixel_format"):
                    assert getattr(found, name) == getattr(original, name)
    finally:
        recording.close()


def test_other_readers_find_a_topic_for_each_component(tmp_path):
    path = tmp_path / "x.mcap"
    writer = create_writer(RecordingKind.MCAP, path, INFO)
    writer.write(frame(1))
    writer.close()
    with path.open("rb") as file:
        topics = sorted(channel.topic for _, channel, _ in make_reader(file).iter_messages())
    assert topics == [
        "/grabbergui/confidence_3/image_raw",
        "/grabbergui/image_raw",
        "/grabbergui/range_1/image_raw",
        "/grabbergui/range_2/image_raw",
    ]


def test_a_frame_with_one_image_is_recorded_as_before(tmp_path):
    path = tmp_path / "x.mcap"
    writer = create_writer(RecordingKind.MCAP, path, INFO)
    plain = frame_of(np.arange(12, dtype=np.uint8).reshape(3, 4))
    plain.received_ns = 10**18
    writer.write(plain)
    writer.close()
    recording = open_recording(path)
    played = recording.frame(0, 5)
    recording.close()
    assert played.parts == () and played.payload_type is PayloadType.IMAGE and recording.scan is None


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", "nan", SCAN.as_json().replace("0.1", "NaN"), SCAN.as_json().replace("900.0", '"9"')],
)
def test_a_description_of_coordinates_that_was_damaged_is_refused(text):
    with pytest.raises(UsageError, match="does not describe 3D coordinates"):
        Scan3d.from_json(text)


def test_a_recording_whose_description_of_coordinates_is_damaged_plays_without_it(tmp_path):
    path = tmp_path / "x.mcap"
    writer = create_writer(RecordingKind.MCAP, path, INFO, scan=SCAN)
    writer.write(frame(1))
    writer.close()
    content = path.read_bytes()
    place = content.index(b'{"calibrated"')
    assert struct.unpack_from("<I", content, place - 4)[0] == len(SCAN.as_json())
    path.write_bytes(content[:place] + b"?" + content[place + 1 :])
    recording = open_recording(path)
    assert recording.scan is None and len(recording.frame(0, 5).components) == 4
    recording.close()


@pytest.mark.parametrize(("kind", "name", "left_out"), [("mcap", "x.mcap", 0), ("png", "x", 1)])
def test_a_camera_is_recorded_and_its_range_measured_again(tmp_path, kind, name, left_out):
    camera = sources.create(SourceUri.parse("sim:?width=64&height=48"))
    camera.open()
    try:
        camera.write_feature("ComponentSelector", "Range")
        camera.write_feature("ComponentEnable", True)
        recorder = create_recorder(camera, tmp_path / name, RecordingKind(kind), RecordingLimits(2))
        recorder.start()
        camera.start()
        assert recorder.wait(PATIENCE)
        expected = read_scan3d(camera)
    finally:
        camera.close()
    assert recorder.progress.error is None and recorder.progress.left_out == left_out

    player = sources.create(SourceUri.parse(f"file:{tmp_path / name}"))
    player.open()
    try:
        queue = player.open_queue()
        player.start()
        frame = queue.get(PATIENCE)
        assert len(frame.components) == 2 - left_out
        if not left_out:
            assert read_scan3d(player) == expected
            distance = expected.distances(frame.components[1].raw(), frame.components[1].pixel_format)
            assert 550 < np.nanmin(distance) < np.nanmax(distance) < 1500
    finally:
        player.close()
