"""Files that others wrote: settings, look-up tables, TIFF pages, YARP's dumps, bags, reports of cameras."""

from __future__ import annotations

import io
import sqlite3
import tempfile
import zipfile
from pathlib import Path

import cv2
import numpy as np

from fuzz._input import Input, erring
from grabbergui.core.lookup_table import LutShape, load_table
from grabbergui.driver.twin import report_file
from grabbergui.models.settings import files
from grabbergui.recording import tiff_pages, yarp_dump
from grabbergui.recording.db3_file import Db3File

FOLDER = Path(tempfile.mkdtemp(prefix="grabbergui-fuzz-"))
SHAPE = LutShape(16, 4095, whole=False)


def seeds() -> list[bytes]:
    """Return a small file of each kind."""
    pixels = np.arange(6 * 5, dtype=np.uint16).reshape(5, 6)
    _, tiff = cv2.imencode(".tiff", pixels)
    pages = FOLDER / "pages.tiff"
    cv2.imwritemulti(str(pages), [pixels, pixels])
    report = io.BytesIO()
    with zipfile.ZipFile(report, "w") as archive:
        archive.writestr("report.json", "{}")
    return [
        b"\0# {05D8C294-F295-4dfb-9D01-096BD04049F4}\n# GenApi persistence file (version 3.1.0)\nGain\t1.5\n",
        b"\0Gain: 1.5\nBalanceRatio[BalanceRatioSelector=Red]: 2\nUser: 'a b'\n",
        b"\0<settings><Gain>1</Gain></settings>",
        b"\1" + b"\n".join(b"%d, %d" % (index, index) for index in range(16)),
        b"\1" + b"\n".join(b"%d" % index for index in range(16)),
        b"\2" + bytes(32),
        b"\3" + tiff.tobytes(),
        b"\3" + pages.read_bytes(),
        b"\4" + b"0 1.5 00000000.ppm [rgb]\n1 1.6 2.5 00000001.ppm\n",
        b"\5" + np.arange(12, dtype=np.float32).tobytes(),
        b"\6" + _bag(),
        b"\7" + report.getvalue(),
    ]


def _bag() -> bytes:
    path = FOLDER / "seed.db3"
    path.unlink(missing_ok=True)
    with sqlite3.connect(path) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT,type TEXT,serialization_format TEXT,"
            "offered_qos_profiles TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER,timestamp INTEGER,data BLOB);"
            "INSERT INTO topics VALUES(1,'/image','sensor_msgs/msg/Image','cdr','');"
            "INSERT INTO messages VALUES(1,1,5,x'00010000');"
        )
    database.close()
    return path.read_bytes()


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    parts = (_settings, _table_of_text, _table, _tiff, _log, _float, _database, _report)
    parts[source.number(1) % len(parts)](source)


def _written(source: Input, name: str) -> Path:
    path = FOLDER / name
    path.write_bytes(source.rest())
    return path


def _settings(source: Input) -> None:
    features = erring(files.load, _written(source, "settings"))
    if features is not None:
        for write in (files.to_yaml, files.to_persistence):
            text = write(features)
            erring(files.parse, text, "again")


def _table_of_text(source: Input) -> None:
    erring(load_table, _written(source, "table.csv"), SHAPE)


def _table(source: Input) -> None:
    erring(load_table, _written(source, "table.bin"), SHAPE)


def _tiff(source: Input) -> None:
    path = _written(source, "pages.tiff")
    for page in (erring(tiff_pages.pages_of, path) or ())[:10]:
        erring(tiff_pages.read_page, path, page)


def _log(source: Input) -> None:
    _written(source, yarp_dump.LOG_NAME)
    erring(yarp_dump.read_log, FOLDER)


def _float(source: Input) -> None:
    data = source.rest()
    for compressed in (False, True):
        erring(lambda compressed: yarp_dump.read_float(data, compressed=compressed), compressed)


def _database(source: Input) -> None:
    opened = erring(Db3File, _written(source, "bag.db3"))
    if opened is not None:
        opened.close()


def _report(source: Input) -> None:
    erring(report_file.decode, source.rest())
