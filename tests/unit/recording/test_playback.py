"""A recording as a source: its features, its pace, and folders that wish us ill."""

import json
import threading

import cv2
import numpy as np
import pytest

from grabbergui.core.component import PayloadType
from grabbergui.core.errors import (
    FeatureAccessError,
    FeatureError,
    FeatureNotFoundError,
    FeatureValueError,
    FrameTimeoutError,
    GrabberError,
    MissingFileError,
    StreamEndedError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.uri import SourceUri
from grabbergui.recording import playback
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.folder import FolderRecording
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import open_recording
from grabbergui.recording.recorder import create_recorder, create_writer
from patience import PATIENCE, attempts, until

STEP_NS = 50_000_000
MANY = 500
"Frames that a queue holds, so that on a busy machine none is dropped."


def note(index, **other):
    known = {
        "file": f"{index}.png",
        "width": 16,
        "height": 8,
        "pixel_format": "Mono8",
        "frame_id": index,
        "received_ns": 10**18 + index * STEP_NS,
    }
    return json.dumps({**known, **other}) + "\n"


@pytest.fixture
def folder(tmp_path):
    for index in range(6):
        cv2.imwrite(str(tmp_path / f"{index}.png"), np.full((8, 16), index * 10, np.uint8))
    (tmp_path / "frames.jsonl").write_text("".join(note(index) for index in range(6)))
    return tmp_path


@pytest.fixture
def player(folder):
    grabber = playback.create(SourceUri.parse(f"file:{folder}"))
    grabber.open()
    yield grabber
    grabber.close()


def test_frames_are_paced_as_recorded(player):
    queue = player.open_queue(MANY)
    player.start()

    def paced():
        steps = np.diff([queue.get(PATIENCE).received_ns for _ in range(6)])
        return np.median(steps) == pytest.approx(STEP_NS, rel=0.3)

    until(paced)


def test_speed_changes_while_it_plays(player):
    player.write_feature("PlaybackSpeed", 10)
    queue = player.open_queue(MANY)
    player.start()
    for watch in attempts(6 * STEP_NS / 1e9):
        with watch:
            for _ in range(12):
                queue.get(PATIENCE)


def test_a_higher_speed_shortens_the_wait_for_the_next_frame(folder):
    (folder / "frames.jsonl").write_text("".join(note(index, received_ns=index * 10**10) for index in (1, 2)))
    player = playback.create(SourceUri.parse(f"file:{folder}?speed=0.05"))
    player.open()
    queue = player.open_queue(MANY)
    player.start()
    assert queue.get(PATIENCE).frame_id == 1
    player.write_feature("PlaybackSpeed", 20)
    assert queue.get(PATIENCE).frame_id == 2  # after 0.5 s; at the old speed, after 200 s
    player.close()


def test_loop_goes_round_and_can_be_ended(player):
    player.write_feature("PlaybackSpeed", 20)
    queue = player.open_queue(MANY)
    player.start()
    ids = [queue.get(PATIENCE).frame_id for _ in range(13)]
    assert ids == [*range(6), *range(6), 0]
    player.write_feature("PlaybackLoop", False)
    with pytest.raises(FrameTimeoutError):
        for _ in range(2 * MANY):
            queue.get(0.5)
    assert player.feature("PlaybackActive").value is False
    assert player.feature("PlaybackPosition").value == 5
    player.write_feature("PlaybackActive", True)
    assert queue.get(PATIENCE).frame_id == 0


def test_while_paused_it_shows_the_position_that_is_set(player):
    player.write_feature("PlaybackActive", False)
    queue = player.open_queue(4)
    player.start()
    assert queue.get(PATIENCE).frame_id == 0
    changed = []
    player.features_changed.connect(changed.append)
    feature = player.write_feature("PlaybackPosition", 3)
    assert feature.value == 3
    frame = queue.get(PATIENCE)
    assert frame.frame_id == 3 and frame.raw()[0, 0] == 30
    with pytest.raises(FrameTimeoutError):
        queue.get(0.2)
    assert any("PlaybackPosition" in names for names in changed)
    assert player.feature("PlaybackTime").value == pytest.approx(0.15)


def test_it_continues_from_a_position_that_was_sought(player):
    player.write_feature("PlaybackActive", False)
    queue = player.open_queue(MANY)
    player.start()
    assert queue.get(PATIENCE).frame_id == 0
    player.write_feature("PlaybackPosition", 3)
    assert queue.get(PATIENCE).frame_id == 3
    player.write_feature("PlaybackActive", True)
    assert [queue.get(PATIENCE).frame_id for _ in range(4)] == [3, 4, 5, 0]


def test_it_continues_from_there_even_if_it_is_just_being_shown(player, folder):
    player.write_feature("PlaybackActive", False)
    queue = player.open_queue(MANY)
    player.start()
    assert queue.get(PATIENCE).frame_id == 0
    (folder / "3.png").write_bytes(b"no image")
    # The notice comes while position 3 is delivered, on the player's own thread.
    player.noticed.connect(lambda _: player.write_feature("PlaybackActive", True))
    player.write_feature("PlaybackPosition", 3)
    assert queue.get(PATIENCE).frame_id == 4
    assert player.statistics().incomplete == 2


def test_its_end_is_reported(player):
    player.write_feature("PlaybackLoop", False)
    player.write_feature("PlaybackSpeed", 20)
    ended = threading.Event()

    def look(names):
        if "PlaybackActive" in names and player.feature("PlaybackActive").value is False:
            ended.set()

    player.features_changed.connect(look)
    player.start()
    assert ended.wait(PATIENCE)
    assert player.feature("PlaybackPosition").value == 5


def test_its_end_follows_the_last_frame_in_every_queue(player):
    player.write_feature("PlaybackLoop", False)
    player.write_feature("PlaybackSpeed", 20)
    queues = [player.open_queue(MANY) for _ in range(2)]
    player.start()
    for queue in queues:
        assert [queue.get(PATIENCE).frame_id for _ in range(6)] == [0, 1, 2, 3, 4, 5]
        with pytest.raises(StreamEndedError):
            queue.get(PATIENCE)
    assert player.silence() == "it was played to its end"


def test_it_waits_for_a_slow_consumer_that_needs_every_frame(player):
    player.write_feature("PlaybackLoop", False)
    player.write_feature("PlaybackSpeed", 20)
    slow = player.open_queue(1)
    slow.needs_all = True
    player.start()
    until(lambda: player.statistics().frames == 1 and slow.full)
    latest = player.open_queue(1)  # whoever waits for a frame gets one, at the cost of the slow one
    until(lambda: latest.full)
    latest.close()
    assert [slow.get(PATIENCE).frame_id for _ in range(5)] == [1, 2, 3, 4, 5]
    assert slow.dropped == 1


def test_a_stop_does_not_wait_for_a_slow_consumer(player):
    slow = player.open_queue(1)
    slow.needs_all = True
    player.start()
    until(lambda: slow.full)
    player.stop()
    assert not player.streaming and slow.dropped == 0


def test_after_its_end_a_start_plays_it_again(player):
    player.write_feature("PlaybackLoop", False)
    player.write_feature("PlaybackSpeed", 20)
    queue = player.open_queue(MANY)
    for _ in range(2):
        player.start()
        assert [queue.get(PATIENCE).frame_id for _ in range(6)] == [0, 1, 2, 3, 4, 5]
        with pytest.raises(StreamEndedError):
            queue.get(PATIENCE)
        player.stop()


def test_after_its_end_it_stays_at_a_position_that_was_sought(player):
    player.write_feature("PlaybackLoop", False)
    player.write_feature("PlaybackPosition", 5)
    queue = player.open_queue(MANY)
    player.start()
    assert queue.get(PATIENCE).frame_id == 5
    with pytest.raises(StreamEndedError):
        queue.get(PATIENCE)
    player.write_feature("PlaybackPosition", 2)
    assert queue.get(PATIENCE).frame_id == 2
    player.stop()
    player.start()
    assert queue.get(PATIENCE).frame_id == 2
    assert player.feature("PlaybackActive").value is False
    assert "paused" in player.silence()


def test_a_recording_of_a_recording_ends_with_it(player, tmp_path):
    player.write_feature("PlaybackLoop", False)
    player.write_feature("PlaybackSpeed", 20)
    recorder = create_recorder(player, tmp_path / "again.npy", RecordingKind.NUMPY)
    recorder.start()
    player.start()
    assert recorder.wait(PATIENCE)
    assert (recorder.progress.frames, recorder.progress.error) == (6, None)


def test_features_match_their_descriptions(player):
    assert player.feature("PlaybackFrameCount").value == 6
    assert player.feature("PlaybackDuration").value == pytest.approx(0.25)
    assert (player.feature("Width").value, player.feature("PixelFormat").value) == (16, "Mono8")
    for description in player.feature_tree().descriptions():
        assert player.feature(description.name).name == description.name
    with pytest.raises(FeatureValueError):
        player.write_feature("PlaybackPosition", 6)
    with pytest.raises(FeatureAccessError):
        player.write_feature("Width", 8)
    with pytest.raises(FeatureNotFoundError, match="PlaybackSpeed"):
        player.write_feature("PlaybackSpeedd", 8)
    with pytest.raises(FeatureError):
        player.execute("PlaybackSpeed")


def test_a_frame_of_another_size_or_format_is_announced(player, folder):
    cv2.imwrite(str(folder / "5.png"), np.zeros((4, 16, 3), np.uint8))
    (folder / "frames.jsonl").write_text(
        "".join(note(index) for index in range(5)) + note(5, height=4, pixel_format="RGB8")
    )
    player.close()
    player.open()
    player.write_feature("PlaybackActive", False)
    announced = set()
    queue = player.open_queue()
    player.start()
    queue.get(PATIENCE)
    player.features_changed.connect(lambda names: announced.update(names))
    player.write_feature("PlaybackPosition", 5)
    queue.get(PATIENCE)
    until(lambda: {"Height", "PixelFormat"} <= announced)
    assert player.feature("Height").value == 4


def test_it_continues_after_a_stop_and_start(player):
    queue = player.open_queue(4)
    player.start()
    player.start()
    queue.get(PATIENCE)
    player.stop()
    player.stop()
    assert player.statistics().frame_rate == 0.0
    assert not player.streaming
    player.start()
    queue.get(PATIENCE)
    assert player.statistics().frames >= 1
    player.close()
    player.close()
    with pytest.raises(GrabberError):
        player.start()


def test_a_start_during_a_stop_leaves_one_player(player, monkeypatch):
    reading, go_on, really = threading.Event(), threading.Event(), FolderRecording.frame

    def slow(recording, index, received_ns):
        reading.set()
        assert go_on.wait(PATIENCE)
        return really(recording, index, received_ns)

    monkeypatch.setattr(FolderRecording, "frame", slow)
    player.start()
    assert reading.wait(PATIENCE)
    threads = [threading.Thread(target=call) for call in (player.stop, player.start)]
    threads[0].start()
    until(lambda: not player.streaming)
    threads[1].start()
    threads[1].join(0.05)  # without a lock it has begun by now, and the player that ends goes on
    go_on.set()
    for thread in threads:
        thread.join(PATIENCE)
    assert not any(thread.is_alive() for thread in threads)
    assert player.streaming
    assert sum(thread.name.startswith("playback ") for thread in threading.enumerate()) == 1


def test_images_without_notes_are_played_by_name(tmp_path):
    for name, pixels in {"a.png": (8, 16), "b.png": (8, 16, 3), "c.tiff": (8, 16)}.items():
        dtype = np.uint16 if name.startswith("c") else np.uint8
        cv2.imwrite(str(tmp_path / name), np.full(pixels, 77, dtype))
    recording = open_recording(tmp_path)
    assert [recording.frame(i, 0).pixel_format.name for i in range(3)] == ["Mono8", "BGR8", "Mono16"]


EVIL = {
    "elsewhere": note(0, file="../../../etc/passwd"),
    "absolute": note(0, file="/etc/passwd"),
    "no file": note(0, file=""),
    "no number": note(0, width="wide"),
    "a boolean": note(0, width=True),
    "huge": note(0, width=10**9),
    "negative": note(0, height=-8),
    "unknown": note(0, pixel_format="Plaid8"),
    "no JSON": "{" * 2000 + "\n",
    "a list": "[1, 2]\n",
    "too long": "x" * 5000,
    "another size": note(0, width=17),
    "not text": "\udcff\n",
    "missing": note(0, file="9.png"),
    "another kind": note(0, pixel_format="Mono16"),
}


@pytest.mark.parametrize("text", EVIL.values(), ids=EVIL)
def test_malicious_notes_are_refused(folder, text):
    (folder / "frames.jsonl").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(GrabberError):
        playback.create(SourceUri.parse(f"file:{folder}")).open()


def test_a_line_cut_short_by_a_crash_is_left_out(folder):
    with (folder / "frames.jsonl").open("a") as file:
        file.write(note(6)[:40])
    assert len(open_recording(folder)) == 6


def test_a_broken_image_is_skipped(folder):
    (folder / "1.png").write_bytes((folder / "1.png").read_bytes()[:30])
    grabber = playback.create(SourceUri.parse(f"file:{folder}?speed=10&loop=0"))
    grabber.open()
    try:
        queue = grabber.open_queue(MANY)
        grabber.start()
        assert [queue.get(PATIENCE).frame_id for _ in range(5)] == [0, 2, 3, 4, 5]
        assert grabber.statistics().incomplete == 1
    finally:
        grabber.close()


@pytest.mark.parametrize("readable", [1, 3, 5])
def test_a_recording_whose_first_images_are_broken_plays_the_others_and_says_so(folder, readable):
    for index in range(6):
        if index != readable:
            (folder / f"{index}.png").write_bytes(b"broken")
    grabber = playback.create(SourceUri.parse(f"file:{folder}?speed=10&loop=0"))
    notices = []
    grabber.noticed.connect(notices.append)
    grabber.open()
    try:
        assert grabber.feature("Width").value == 16
        assert len(notices) == 1 and "0.png" in notices[0]
        queue = grabber.open_queue(MANY)
        grabber.start()
        assert queue.get(PATIENCE).frame_id == readable
        until(lambda: grabber.statistics().incomplete == 5)
        assert "0.png" not in "".join(notices[1:]), "once is enough"
    finally:
        grabber.close()


def test_a_recording_without_a_readable_image_is_refused(folder):
    for index in range(6):
        (folder / f"{index}.png").write_bytes(b"broken")
    with pytest.raises(RecordingError, match=r"0\.png"):
        playback.create(SourceUri.parse(f"file:{folder}")).open()


def test_a_path_without_a_recording_is_refused_with_advice(tmp_path):
    (tmp_path / "notes.txt").write_text("no")
    for name in ("a.mcap", "a.mp4"):
        (tmp_path / name).write_bytes(b"\0" * 100)
        with pytest.raises(UsageError):
            open_recording(tmp_path / name)
    with pytest.raises(UsageError):
        open_recording(tmp_path / "notes.txt")
    (tmp_path / "empty").mkdir()
    with pytest.raises(UsageError, match="no images"):
        open_recording(tmp_path / "empty")
    with pytest.raises(MissingFileError):
        open_recording(tmp_path / "nothing")
    for uri in ("file:", "file:x?loop=maybe", "file:x?speed=fast", "file:x?volume=11"):
        with pytest.raises(UsageError):
            playback.create(SourceUri.parse(uri))


@pytest.mark.parametrize("name", ["x" * 5000, "~nobody-of-this-name/movie.mp4"])
def test_names_that_no_system_allows_are_refused_like_any_other(name):
    with pytest.raises(GrabberError):
        playback.create(SourceUri("file", name)).open()


def test_a_disk_that_is_gone_is_reported_once(player, folder, caplog):
    noticed = []
    player.noticed.connect(noticed.append)
    queue = player.open_queue(MANY)
    player.start()
    queue.get(PATIENCE)
    folder.rename(folder.with_name("unplugged"))
    until(lambda: player.statistics().incomplete > 10, "frames that cannot be read")
    assert len(noticed) == len(caplog.records) == 1 and "could not be read: No such file" in noticed[0]
    folder.with_name("unplugged").rename(folder)
    queue.clear()
    queue.get(PATIENCE)
    (folder / "3.png").unlink()
    until(lambda: len(noticed) == 2, "another loss")


def test_a_folder_that_cannot_be_listed_is_reported(tmp_path, monkeypatch):
    def closed(path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(tmp_path), "iterdir", closed)
    with pytest.raises(RecordingError, match=r"could not be read: Permission denied"):
        playback.create(SourceUri("file", str(tmp_path))).open()


@pytest.mark.parametrize("kind", ["RGBa8", "BGRa8"])
def test_an_image_without_the_alpha_that_is_noted_is_refused(tmp_path, kind):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((8, 16, 3), np.uint8))
    (tmp_path / "frames.jsonl").write_text(note(0, pixel_format=kind))
    with pytest.raises(RecordingError, match="no alpha"):
        playback.create(SourceUri("file", str(tmp_path))).open()


@pytest.mark.parametrize("components", [3, 4])
def test_colour_of_16_bits_by_others_is_played(tmp_path, components):
    cv2.imwrite(
        str(tmp_path / "0.png"), np.full((8, 16, components), (10, 200, 60000, 65535)[:components], np.uint16)
    )
    frame = open_recording(tmp_path).frame(0, 0)
    assert frame.raw()[0, 0].tolist()[:3] == [10, 200, 60000]
    assert frame.rgb()[0, 0].tolist() == [60000 >> 8, 0, 0]


def test_a_note_may_give_a_format_by_its_code(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), np.full((8, 16, 3), (1, 2, 3), np.uint8))
    (tmp_path / "frames.jsonl").write_text(note(0, pixel_format="0x02180014"))
    assert open_recording(tmp_path).frame(0, 0).rgb()[0, 0].tolist() == [3, 2, 1]


@pytest.mark.parametrize(
    ("values", "name"),
    [(np.int16, "Data16s"), (np.float32, "Coord3D_C32f"), (np.int32, "Data32s"), (np.float64, "Data64f")],
)
def test_images_of_depth_and_signed_values_are_played(tmp_path, values, name):
    cv2.imwrite(str(tmp_path / "0.tiff"), np.full((8, 16), -7, values))
    frame = open_recording(tmp_path).frame(0, 0)
    assert frame.pixel_format.name == name and (frame.raw() == -7).all()


def test_images_with_values_of_no_sensor_are_refused(tmp_path):
    cv2.imwrite(str(tmp_path / "0.tiff"), np.full((8, 16, 3), -7, np.int16))
    with pytest.raises(RecordingError, match=r"0\.tiff has 3 components of int16"):
        playback.create(SourceUri("file", str(tmp_path))).open()


@pytest.mark.parametrize("kind", [PayloadType.RAW_DATA, PayloadType.FILE, PayloadType.CHUNK])
def test_a_payload_without_an_image_is_recorded_and_played(tmp_path, kind):
    payload = np.arange(100, dtype=np.uint8)
    recorded = Frame(payload, 0, 0, PixelFormat(kind.value, 0), frame_id=7, payload_type=kind)
    writer = create_writer(RecordingKind.PNG, tmp_path / "run", DeviceInfo("sim:"))
    writer.write(recorded)
    writer.close()
    frame = open_recording(tmp_path / "run").frame(0, 0)
    assert (frame.payload_type, frame.frame_id, frame.components) == (kind, 7, ())
    assert np.array_equal(frame.payload, payload)


def test_an_image_of_no_pixels_is_refused(tmp_path):
    (tmp_path / "frames.jsonl").write_text(note(0, width=0, height=0))
    with pytest.raises(UsageError, match="0×0 pixels is impossible"):
        open_recording(tmp_path)
