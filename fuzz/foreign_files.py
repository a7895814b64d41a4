"""Files of other programs: settings, tables, TIFF, NumPy arrays, databases of rosbag2, YARP's dumps."""

from __future__ import annotations

import contextlib
import io
import sqlite3
import struct
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from fuzz._input import Input, erring, refusing
from grabbergui.calibration import camera_info
from grabbergui.core import ros_image
from grabbergui.core.lookup_table import LutShape, load_table
from grabbergui.core.ros_image import RosCompressedImage, RosImage
from grabbergui.core.ros_pictures import of_compressed, of_image
from grabbergui.models.settings import files
from grabbergui.recording import bag_folder, yarp_dump
from grabbergui.recording.db3_file import Db3File
from grabbergui.recording.folder import FolderRecording
from grabbergui.recording.npy_file import NpyRecording
from grabbergui.recording.opening import open_recording
from grabbergui.recording.reader import RecordingReader
from grabbergui.recording.ros_recording import RosRecording

FOLDER = Path(tempfile.mkdtemp(prefix="grabbergui-fuzz-"))
MOST_FRAMES = 20
_PERSISTENT = f"# {files.BAG_GUID}\n# Device = X\nGainSelector\tAll\nGain\t1\nGainSelector\tRed\nGain\t2\n"
_OST = """[image]
width
64
height
48
[camera]
camera matrix
50 0 32
0 50 24
0 0 1
distortion
0 0 0 0 0
"""


def seeds() -> list[bytes]:
    """Return a small file of each kind."""
    array = io.BytesIO()
    np.save(array, np.zeros((2, 4, 6), np.uint16))
    image = RosImage(5, "camera", 4, 6, "nv12", 0, 6, bytes(36))
    still = cv2.imencode(".png", np.zeros((4, 6), np.uint16))[1].tobytes()
    pages = [
        cv2.imencodemulti(".tiff", [np.zeros((4, 6), np.uint8)] * 2, [cv2.IMWRITE_TIFF_COMPRESSION, c])
        for c in (1, 5)
    ]
    return [
        b"\0" + _PERSISTENT.encode(),
        b"\0" + b'device: x\nfeatures:\n  Gain[GainSelector=Red]: 1.5\n  Text: "a"\n',
        b"\0" + _PERSISTENT.encode("utf-16"),
        b"\0" + b'<?xml version="1.0"?><CameraSettings/>',
        b"\1" + b"index,value\n0,1\n1,2\n2,3\n3,4\n",
        b"\2" + _database(image.encode()),
        *(b"\3" + page.tobytes() for _, page in pages),
        b"\4" + array.getvalue(),
        b"\5" + b"1 10.5 99.0 00000000.pgm [mono]\n2 11.0 00000001.float\n",
        b"\6" + struct.pack("<QQ", 4, 6) + zlib.compress(bytes(96)),
        b"\7" + image.encode(),
        b"\x08" + _compressed("16UC1; compressedDepth png", bytes(12) + still),
        b"\x08" + _compressed("mono16; png", still),
        b"\x09" + _OST.encode(),
        b"\x09" + b"a: 1\n---\nimage_width: 64\n---\n",
        b"\x0a"
        + b"rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3\n    - x/bag_1.mcap\n",
    ]


def _compressed(described: str, data: bytes) -> bytes:
    text = described.encode() + b"\0"
    head = b"\0\1\0\0" + struct.pack("<iII", 1, 2, 1) + b"\0\0\0\0" + struct.pack("<I", len(text)) + text
    return head + bytes(-(len(head) - 4) % 4) + struct.pack("<I", len(data)) + data


def _database(message: bytes) -> bytes:
    path = FOLDER / "seed.db3"
    with contextlib.closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA page_size = 512")
        database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)")
        database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
        database.execute("INSERT INTO topics VALUES(1, '/i', ?, 'cdr')", (ros_image.IMAGE_NAME,))
        database.execute("INSERT INTO messages VALUES(1, 1, 5, ?)", (message,))
        database.commit()
    content = path.read_bytes()
    path.unlink()
    return content


def one_input(data: bytes) -> None:
    """Feed the reader that the first byte chooses."""
    source = Input(data)
    readers = (
        _settings,
        _table,
        _db3,
        _tiff,
        _npy,
        _log,
        _float,
        _image,
        _compressed_image,
        _calibration,
        _metadata,
    )
    readers[source.number(1) % len(readers)](source.rest())


def _written(name: str, content: bytes) -> Path:
    path = FOLDER / name
    path.write_bytes(content)
    return path


def _settings(content: bytes) -> None:
    path = _written("x.pfs", content)
    found = erring(files.load, path)
    if found is not None:
        erring(files.parse, files.to_persistence(found), "again")
        again = files.parse(files.to_yaml(found), "again")
        if len(again) != len(found):
            raise AssertionError(found)


def _table(content: bytes) -> None:
    for name in ("x.csv", "x.bin"):
        table = erring(load_table, _written(name, content), LutShape(4, 255, whole=True))
        if table is not None and table.shape != (4,):
            raise AssertionError(table)


def _played(opening: Callable[[], RecordingReader]) -> None:
    recording = erring(opening)
    if recording is not None:
        for index in range(min(len(recording), MOST_FRAMES)):
            erring(recording.frame, index, 0)
        recording.close()


def _db3(content: bytes) -> None:
    path = _written("x.db3", content)
    _played(lambda: RosRecording(path, [Db3File(path)]))


def _tiff(content: bytes) -> None:
    path = _written("x.tiff", content)
    _played(lambda: FolderRecording(path))


def _npy(content: bytes) -> None:
    path = _written("x.npy", content)
    _played(lambda: NpyRecording(path))


def _log(content: bytes) -> None:
    folder = FOLDER / "dump"
    folder.mkdir(exist_ok=True)
    (folder / yarp_dump.LOG_NAME).write_bytes(content)
    for each in erring(yarp_dump.read_log, folder) or ():
        if "/" in each.file or each.time_ns < 0:
            raise AssertionError(each)
    _played(lambda: open_recording(folder))


def _float(content: bytes) -> None:
    for compressed in (False, True):
        refusing(lambda: yarp_dump.read_float(content, compressed=compressed))  # noqa: B023, called at once


def _image(content: bytes) -> None:
    image = refusing(RosImage.decode, content)
    if image is not None:
        erring(of_image, image)


def _compressed_image(content: bytes) -> None:
    image = refusing(RosCompressedImage.decode, content)
    if image is not None:
        erring(of_compressed, image)


def _calibration(content: bytes) -> None:
    calibration = erring(camera_info.parse, content.decode("utf-8", "replace"))
    if calibration is not None:
        camera_info.parse(camera_info.dump(calibration))


def _metadata(content: bytes) -> None:
    folder = FOLDER / "bag"
    folder.mkdir(exist_ok=True)
    (folder / "bag_0.db3").touch()
    (folder / bag_folder.METADATA).write_bytes(content)
    for path in erring(bag_folder.bag_files, folder) or ():
        if path.parent != folder:
            raise AssertionError(path)
