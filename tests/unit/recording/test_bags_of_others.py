"""Recordings of ROS 2 as others write them: rosbag2's folders and databases, every kind of image."""

import contextlib
import shutil
import sqlite3
import struct
import time

import cv2
import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from grabbergui.core.component import ComponentKind
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.ros_image import IMAGE_DEFINITION, IMAGE_NAME, RosImage
from grabbergui.recording import mcap_file
from grabbergui.recording.bag_folder import bag_files
from grabbergui.recording.db3_file import Db3File
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.opening import open_recording

SECOND = 10**9


@pytest.fixture
def ros():
    """The typestore of `rosbags`, and its writer."""
    typesys = pytest.importorskip("rosbags.typesys", reason="needs the package rosbags")
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    return typesys.get_typestore(typesys.Stores.ROS2_HUMBLE), rosbag2


def header(store, ns):
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](sec=ns // SECOND, nanosec=ns % SECOND)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera")


def image(store, pixels, encoding, ns=0, step=None):
    data = np.ascontiguousarray(pixels)
    height, width = data.shape[:2]
    return store.types["sensor_msgs/msg/Image"](
        header=header(store, ns),
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=step or data.nbytes // height,
        data=data.reshape(-1).view(np.uint8),
    )


def compressed(store, content, described, ns=0):
    return store.types["sensor_msgs/msg/CompressedImage"](
        header=header(store, ns), format=described, data=np.frombuffer(content, np.uint8)
    )


def write_bag(ros, folder, messages, plugin="SQLITE3"):
    """Write (topic, type's name, message, time) as `ros2 bag record` does."""
    store, rosbag2 = ros
    connections = {}
    with rosbag2.Writer(folder, version=8, storage_plugin=rosbag2.StoragePlugin[plugin]) as writer:
        for topic, message, ns in messages:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], ns, store.serialize_cdr(message, kind))
    return folder


def played(path, **options):
    with contextlib.closing(open_recording(path, **options)) as recording:
        return [recording.frame(index, 0) for index in range(len(recording))]


def flat(value, dtype=np.uint8, shape=(4, 6)):
    return np.full(shape, value, dtype)


@pytest.mark.parametrize("plugin", ["SQLITE3", "MCAP"])
def test_a_folder_of_rosbag2_is_played(ros, tmp_path, plugin):
    store, _ = ros
    messages = [("/camera/image_raw", image(store, flat(i), "mono8"), SECOND * (i + 1)) for i in range(5)]
    messages.insert(2, ("/chatter", store.types["std_msgs/msg/String"](data="hello"), 3 * SECOND))
    folder = write_bag(ros, tmp_path / "bag", messages, plugin)
    with contextlib.closing(open_recording(folder)) as recording:
        assert [int(recording.frame(i, 0).raw()[0, 0]) for i in range(5)] == [0, 1, 2, 3, 4]
        assert recording.times_ns == [SECOND * (i + 1) for i in range(5)]
        assert recording.title == "bag /camera/image_raw"
    file = next(path for path in folder.iterdir() if path.suffix in (".db3", ".mcap"))
    assert len(played(file)) == 5


@pytest.mark.parametrize("plugin", ["SQLITE3", "MCAP"])
def test_several_files_are_played_in_the_order_of_the_metadata(ros, tmp_path, plugin):
    """As `ros2 bag record --max-bag-size` splits them; here the names contradict the order."""
    store, _ = ros
    whole = tmp_path / "bag"
    whole.mkdir()
    suffix = {"SQLITE3": ".db3", "MCAP": ".mcap"}[plugin]
    names = [f"bag_{number}{suffix}" for number in (10, 9, 2)]
    for part, name in enumerate(names):
        messages = [
            ("/image", image(store, flat(10 * part + i), "mono8"), SECOND * (10 * part + i + 1))
            for i in range(3)
        ]
        folder = write_bag(ros, tmp_path / f"part{part}", messages, plugin)
        (written,) = (path for path in folder.iterdir() if path.suffix == suffix)
        shutil.copy(written, whole / name)
    listed = "".join(f"    - {name}\n" for name in names)
    before, after = "rosbag2_bagfile_information:\n  version: 8\n", "  duration:\n    nanoseconds: 1\n"
    metadata = f"{before}  relative_file_paths:\n{listed}{after}"
    (whole / "metadata.yaml").write_text(metadata)
    values = [int(frame.raw()[0, 0]) for frame in played(whole)]
    assert values == [0, 1, 2, 10, 11, 12, 20, 21, 22]

    (whole / "metadata.yaml").write_text(metadata.replace("- bag", "- old_folder/bag"))
    assert len(played(whole)) == 9
    (whole / "metadata.yaml").unlink()  # in natural order, and by their times
    assert sorted(int(frame.raw()[0, 0]) for frame in played(whole)) == values
    (whole / "metadata.yaml").write_text(metadata.replace("bag_2", "bag_3"))
    with pytest.raises(UsageError, match=r"bag_3.*which metadata.yaml lists, is missing"):
        open_recording(whole)


def test_metadata_of_millions_of_lines_takes_no_time(tmp_path):
    (tmp_path / "bag_0.mcap").touch()
    (tmp_path / "metadata.yaml").write_text("\n" * (1 << 20) + "  relative_file_paths:\n    - bag_0.mcap\n")
    begun = time.process_time()
    assert bag_files(tmp_path) == [tmp_path / "bag_0.mcap"]
    assert time.process_time() - begun < 5


def test_a_folder_that_is_compressed_as_a_whole_says_how_to_play_it(tmp_path):
    (tmp_path / "bag_0.db3.zstd").touch()
    with pytest.raises(UsageError, match="zstd -d"):
        open_recording(tmp_path)


RGB = np.random.default_rng(1).integers(0, 256, (4, 6, 3), np.uint8)
NV = np.random.default_rng(2).integers(0, 256, (6, 6), np.uint8)
"A 4:2:0 image of 6 × 4: four lines of luma, two of chroma."
DEPTH16 = np.arange(24, dtype=np.uint16).reshape(4, 6) * 1000
DEPTH32 = np.linspace(0.5, 9, 24, dtype=np.float32).reshape(4, 6)


@pytest.mark.parametrize(
    ("pixels", "encoding", "name", "expected"),
    [
        (RGB[..., :2], "8UC2", "Coord3D_AC8", RGB[..., :2]),
        (np.dstack([DEPTH32] * 4), "32FC4", "Coord3D_ABC32f", np.dstack([DEPTH32] * 3)),
        (DEPTH16, "16UC1", "Coord3D_C16", DEPTH16),
        (DEPTH32, "32FC1", "Coord3D_C32f", DEPTH32),
        (DEPTH16.astype(np.int32), "32SC1", "Data32s", DEPTH16),
        (RGB, "bgr8", "BGR8", RGB),
    ],
)
def test_every_encoding_is_played(ros, tmp_path, pixels, encoding, name, expected):
    store, _ = ros
    (frame,) = played(write_bag(ros, tmp_path / "bag", [("/i", image(store, pixels, encoding), 1)]))
    assert frame.pixel_format.name == name and np.array_equal(frame.raw(), expected)


@pytest.mark.parametrize(
    ("encoding", "conversion"),
    [("nv12", cv2.COLOR_YUV2RGB_NV12), ("nv21", cv2.COLOR_YUV2RGB_NV21), ("i420", cv2.COLOR_YUV2RGB_I420)],
)
def test_subsampled_chroma_has_opencvs_colours(ros, tmp_path, encoding, conversion):
    store, _ = ros
    message = image(store, NV, encoding)
    message.height = 4
    (frame,) = played(write_bag(ros, tmp_path / "bag", [("/i", message, 1)]))
    assert frame.pixel_format.name == "YUV422_8" and np.array_equal(frame.raw()[..., 0], NV[:4])
    difference = frame.rgb().astype(int) - cv2.cvtColor(NV, conversion)
    if encoding != "i420":  # OpenCV has video's range of values, 16 to 235, PFNC's YUV422_8 the whole
        chroma = NV[4:].reshape(2, 3, 2)[..., :: 1 if encoding == "nv12" else -1]
    else:
        chroma = np.dstack([NV[4:].reshape(-1)[:6].reshape(2, 3), NV[4:].reshape(-1)[6:].reshape(2, 3)])
    assert np.array_equal(frame.raw()[::2, 0::2, 1], chroma[..., 0])
    assert np.array_equal(frame.raw()[1::2, 1::2, 1], chroma[..., 1])
    assert np.median(np.abs(difference)) < 40


def test_nv24_keeps_every_sample(ros, tmp_path):
    store, _ = ros
    data = np.random.default_rng(3).integers(
        0, 256, (12, 6), np.uint8
    )  # 4 lines of luma, 4 of 12 bytes of chroma
    message = image(store, data, "nv24")
    message.height = 4
    (frame,) = played(write_bag(ros, tmp_path / "bag", [("/i", message, 1)]))
    assert frame.pixel_format.name == "YUV8_UYV"
    chroma = data[4:].reshape(4, 6, 2)
    assert np.array_equal(frame.raw(), np.dstack([chroma[..., 0], data[:4], chroma[..., 1]]))


@pytest.mark.parametrize(
    ("suffix", "pixels", "described", "name"),
    [
        (".png", RGB, "bgr8; png compressed bgr8", "BGR8"),
        (".png", RGB, "png", "BGR8"),
        (".png", DEPTH16, "mono16; png compressed mono16", "Mono16"),
        (".png", DEPTH16, "16UC1; png compressed 16UC1", "Coord3D_C16"),
        (".png", RGB[..., 0], "bayer_rggb8; png compressed bayer_rggb8", "BayerRG8"),
        (".tiff", DEPTH32, "32FC1; tiff compressed", "Coord3D_C32f"),
    ],
)
def test_compressed_images_are_played(ros, tmp_path, suffix, pixels, described, name):
    store, _ = ros
    content = cv2.imencode(suffix, pixels)[1].tobytes()
    messages = [("/i/compressed", compressed(store, content, described), SECOND)]
    (frame,) = played(write_bag(ros, tmp_path / "bag", messages, "MCAP"))
    assert frame.pixel_format.name == name and np.array_equal(frame.raw(), pixels)


def test_a_jpeg_is_played_in_its_colours(ros, tmp_path):
    store, _ = ros
    content = cv2.imencode(".jpg", np.full((16, 16, 3), (200, 100, 30), np.uint8))[1].tobytes()
    (frame,) = played(
        write_bag(
            ros, tmp_path / "bag", [("/i", compressed(store, content, "rgb8; jpeg compressed bgr8"), 1)]
        )
    )
    assert np.abs(frame.rgb()[8, 8].astype(int) - (30, 100, 200)).max() < 4


def test_compressed_depth_is_decoded(ros, tmp_path):
    store, _ = ros
    head = struct.pack("<iff", 0, 0.0, 0.0)
    plain = head + cv2.imencode(".png", DEPTH16)[1].tobytes()
    a, b = 100.0 * (100 + 1), 1 - 100.0 * (100 + 1) / 10  # image_transport's for quantisation 100 and 10 m
    inverse = np.where(DEPTH32 < 9, a / DEPTH32 + b, 0).astype(np.uint16)
    packed = struct.pack("<iff", 1, a, b) + cv2.imencode(".png", inverse)[1].tobytes()
    for content, encoding, name, expected in (
        (plain, "16UC1", "Coord3D_C16", DEPTH16),
        (packed, "32FC1", "Coord3D_C32f", np.where(DEPTH32 < 9, DEPTH32, np.nan)),
    ):
        folder = tmp_path / encoding
        message = compressed(store, content, f"{encoding}; compressedDepth png")
        (frame,) = played(write_bag(ros, folder, [("/d", message, 1)]))
        assert frame.pixel_format.name == name
        assert np.allclose(frame.raw(), expected, rtol=0.02, equal_nan=True)


def test_the_topic_is_chosen_or_all_are_played(ros, tmp_path):
    store, _ = ros
    messages = []
    for index in range(6):
        messages.append(("/left/image", image(store, flat(index), "mono8"), SECOND * (index + 1)))
        if index % 2:
            messages.append(
                ("/right/image", image(store, flat(100 + index), "mono8"), SECOND * (index + 1) + 5)
            )
            messages.append(
                ("/depth", image(store, flat(index, np.uint16), "16UC1"), SECOND * (index + 1) - 5)
            )
    folder = write_bag(ros, tmp_path / "bag", messages)
    with contextlib.closing(open_recording(folder)) as recording:
        assert len(recording) == 6 and "?topic=NAME" in recording.remark
        assert "/right/image (3)" in recording.remark and "/depth (3)" in recording.remark
    right = played(folder, topic="/right/image")
    assert [int(frame.raw()[0, 0]) for frame in right] == [101, 103, 105]
    with pytest.raises(UsageError, match="no images on /up; there are /depth, /left/image, /right/image"):
        open_recording(folder, topic="/up")

    everything = played(folder, topic="all")
    assert [len(frame.parts) for frame in everything] == [0, 2, 3, 3, 3, 3]
    values = [sorted(int(part.raw()[0, 0]) for part in frame.parts) for frame in everything]
    assert values[3] == [3, 3, 101] and values[5] == [5, 5, 103]
    assert {part.kind for part in everything[3].parts} == {ComponentKind.UNDEFINED, ComponentKind.RANGE}


def test_of_a_camera_with_both_the_plain_images_are_played(ros, tmp_path):
    store, _ = ros
    content = cv2.imencode(".jpg", RGB)[1].tobytes()
    messages = [
        ("/i/compressed", compressed(store, content, "jpeg"), 1),
        ("/i", image(store, RGB, "rgb8"), 2),
    ]
    (frame,) = played(write_bag(ros, tmp_path / "bag", messages))
    assert np.array_equal(frame.rgb(), RGB)


def test_stamps_of_headers_replace_log_times_of_zero(ros, tmp_path):
    store, _ = ros
    times = [5 * SECOND, 5 * SECOND + 40_000_000, 6 * SECOND]
    messages = [("/i", image(store, flat(i), "mono8", ns), 0) for i, ns in enumerate(times)]
    with contextlib.closing(open_recording(write_bag(ros, tmp_path / "bag", messages))) as recording:
        assert recording.times_ns == times
    messages = [("/i", image(store, flat(i), "mono8"), 0) for i in range(3)]
    with contextlib.closing(open_recording(write_bag(ros, tmp_path / "none", messages))) as recording:
        assert np.diff(recording.times_ns).tolist() == [40_000_000] * 2


def test_what_it_holds_instead_of_images_is_named(ros, tmp_path):
    store, _ = ros
    folder = write_bag(ros, tmp_path / "bag", [("/c", store.types["std_msgs/msg/String"](data="x"), 1)])
    with pytest.raises(UsageError, match=r"holds no images of the type .*but std_msgs/msg/String"):
        open_recording(folder)


def test_images_of_ros_1_are_refused_by_their_encoding(tmp_path):
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros1")
        schema = writer.register_schema("sensor_msgs/Image", "ros1msg", b"")
        writer.add_message(writer.register_channel("/i", "ros1", schema), 1, b"123", 1)
        writer.finish()
    with pytest.raises(UsageError, match="images of the type sensor_msgs/Image in the encoding 'ros1'"):
        open_recording(path)


def chunk_of(content, announced=None):
    data = zstandard.compress(content)
    body = (
        struct.pack("<QQQII", 0, 0, announced or len(content), 0, 4)
        + b"zstd"
        + struct.pack("<Q", len(data))
        + data
    )
    return struct.pack("<BQ", 6, len(body)) + body


def test_a_bomb_of_zstd_is_refused_before_it_is_expanded(tmp_path):
    path = tmp_path / "x.mcap"
    path.write_bytes(mcap_file.MAGIC + chunk_of(bytes(1000), announced=870 << 20))
    with pytest.raises(UsageError, match="announces 912261120 bytes; at most 268435456"):
        open_recording(path)


def test_many_small_bombs_are_refused_too(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_file, "MOST_EXPANDED", 1 << 20)
    path = tmp_path / "x.mcap"
    path.write_bytes(mcap_file.MAGIC + chunk_of(bytes(1 << 20)) * 8)
    with pytest.raises(UsageError, match="announces to grow beyond 1000 times that"):
        open_recording(path)


def database(path, script):
    with contextlib.closing(sqlite3.connect(path)) as connection:
        connection.executescript(script)
    return path


TOPICS = """CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
INSERT INTO topics VALUES(1, '/i', 'sensor_msgs/msg/Image', 'cdr');"""
MESSAGES = "CREATE TABLE messages(id, topic_id, timestamp, data);"
COUNTING = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT"


@pytest.mark.parametrize(
    "script",
    [
        "CREATE TABLE other(x)",
        TOPICS,
        f"{TOPICS} {MESSAGES}",
        f"{TOPICS} {MESSAGES} INSERT INTO messages VALUES('a', 1, 'b', 3.5)",
        f"{TOPICS} CREATE VIEW messages AS {COUNTING} x id, 1 topic_id, x timestamp, zeroblob(9) data FROM n",
        f"CREATE VIEW topics AS {COUNTING} x id, 'a' name, 'b' type, 'cdr' serialization_format FROM n",
    ],
)
def test_a_hostile_database_is_refused_in_time(tmp_path, monkeypatch, script):
    from grabbergui.recording import db3_file

    monkeypatch.setattr(db3_file, "QUERY_TIME", 0.3)
    path = database(tmp_path / "x.db3", script)
    begun = time.monotonic()
    with pytest.raises(GrabberError, match=r"x\.db3"):
        open_recording(path)
    assert time.monotonic() - begun < 20


def test_a_message_that_takes_for_ever_is_given_up(tmp_path, monkeypatch):
    from grabbergui.recording import db3_file

    path = database(
        tmp_path / "x.db3",
        f"""{TOPICS} CREATE VIEW messages AS SELECT 1 AS id, 1 AS topic_id, 1 AS timestamp,
        (SELECT max(y) FROM ({COUNTING} x AS y FROM n)) AS data;""",
    )
    monkeypatch.setattr(db3_file, "QUERY_TIME", 0.2)
    monkeypatch.setattr(db3_file, "READ_TIME", 0.2)
    with pytest.raises(GrabberError):
        played(path)


@pytest.mark.parametrize(
    "content", [b"", b"SQLite format 3\0" + bytes(100), b"SQLite format 3\0" + bytes(range(256)) * 20]
)
def test_what_is_no_database_is_refused(tmp_path, content):
    (path := tmp_path / "x.db3").write_bytes(content)
    with pytest.raises(UsageError, match=r"x\.db3"):
        open_recording(path)


def test_broken_bytes_of_a_database_give_no_traceback(ros, tmp_path):
    store, _ = ros
    messages = [("/i", image(store, flat(i, shape=(40, 60)), "mono8"), i + 1) for i in range(4)]
    folder = write_bag(ros, tmp_path / "bag", messages)
    (file,) = folder.glob("*.db3")
    content, rng, right = file.read_bytes(), np.random.default_rng(4), 0
    for _ in range(60):
        broken = bytearray(content)
        for at in rng.integers(100, len(content), 4):
            broken[at] = rng.integers(0, 256)
        (tmp_path / "broken.db3").write_bytes(broken)
        with contextlib.suppress(GrabberError):
            right += len(played(tmp_path / "broken.db3"))
    assert right > 20


def test_a_recording_of_a_database_is_not_written_to(ros, tmp_path, monkeypatch):
    store, _ = ros
    folder = write_bag(ros, tmp_path / "bag", [("/i", image(store, flat(1), "mono8"), 1)])
    (file,) = folder.glob("*.db3")
    before, names = file.read_bytes(), sorted(path.name for path in folder.iterdir())
    assert len(played(folder)) == 1
    assert file.read_bytes() == before and sorted(path.name for path in folder.iterdir()) == names
    connect, databases = sqlite3.connect, []
    monkeypatch.setattr(
        sqlite3,
        "connect",
        lambda *place, **options: databases.append(connect(*place, **options)) or databases[0],
    )
    with contextlib.closing(Db3File(file)), pytest.raises(sqlite3.OperationalError):
        databases[0].execute("DELETE FROM messages")


def test_images_that_cannot_be_are_refused_one_by_one(ros, tmp_path):
    store, _ = ros
    odd = image(store, np.zeros((5, 5), np.uint8), "nv12")
    odd.height = 3
    messages = [
        ("/i", odd, 1),
        ("/i", image(store, np.zeros((4, 6), np.uint8), "nv24"), 2),
        ("/i", image(store, np.zeros((4, 6), np.uint8), "32FC4"), 3),
        ("/i", image(store, np.zeros((4, 6), np.uint8), "rainbow"), 4),
        ("/j", compressed(store, b"\x89PNG", "png"), 5),
    ]
    folder = write_bag(ros, tmp_path / "bag", messages)
    with contextlib.closing(open_recording(folder)) as recording:
        for index, reported in enumerate(
            ["even sides", "impossible", "impossible", "'rainbow' cannot be shown"]
        ):
            with pytest.raises(RecordingError, match=reported):
                recording.frame(index, 0)
    with (
        contextlib.closing(open_recording(folder, topic="/j")) as recording,
        pytest.raises(RecordingError, match="no image, or one"),
    ):
        recording.frame(0, 0)


def test_a_foreign_file_of_mcap_is_played_with_its_topics(tmp_path):
    """A file in which the types of others are many, as of a robot."""
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start("ros2")
        schema = writer.register_schema(IMAGE_NAME, "ros2msg", IMAGE_DEFINITION.encode())
        other = writer.register_schema("tf2_msgs/msg/TFMessage", "ros2msg", b"")
        channel, transforms = (
            writer.register_channel("/i", "cdr", schema),
            writer.register_channel("/tf", "cdr", other),
        )
        for index in range(50):
            writer.add_message(transforms, index, bytes(100), index)
        writer.add_message(channel, 1, RosImage(0, "c", 2, 2, "mono8", 0, 2, b"1234").encode(), 1)
        writer.finish()
    store = mcap_file.McapFile(path)
    assert len(store.messages) == 1
    store.close()
    assert len(played(path)) == 1
