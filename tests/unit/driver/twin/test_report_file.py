"""The file of a report: written and read back, and hostile files."""

from __future__ import annotations

import io
import json
import random
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from every_case import every_case
from grabbergui import sources
from grabbergui.core.errors import DeviceStatusError, MissingFileError, UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device import DataLayout, Device
from grabbergui.driver.twin import memory, report_file
from grabbergui.driver.twin.memory import TwinMemory
from grabbergui.driver.twin.model import LARGEST_FRAME, TwinModel
from grabbergui.driver.twin.recorded_device import RecordedDevice
from grabbergui.driver.twin.report_file import (
    CameraReport,
    FrameRecord,
    PacketTest,
    RecordedAccess,
    StreamRecord,
    decode,
    encode,
)

REPORT = CameraReport(
    DeviceInfo("gige:7", "Acme", "Eye", "7"),
    chunk_layout=DataLayout.GIGE_VISION,
    little_endian=True,
    description=b"<RegisterDescription/>",
    registers=(
        RecordedAccess(0x1_0000_0000, 4, b"\1\2\3\4", 1.25, name="Width"),
        RecordedAccess(0x200, 8, None, 3.0, "DeviceStatusError", 0x8006, "no", "Gain"),
    ),
    bootstrap=(RecordedAccess(0, 4, b"\0\2\0\0", name="VERSION"),),
    stream=StreamRecord(
        frames=(FrameRecord(1, 2, 3, 4, 5, 0x01080001, 20, "image", chunks={"ChunkGain": 1.5}),),
        statistics={"frames": 1},
        packet_tests=(PacketTest(9000, False), PacketTest(1500, True)),
        accesses=(RecordedAccess(0x300, 4, b"\0\0\0\1", written=True),),
        started=True,
    ),
    features=({"name": "Width", "value": 4},),
    problems=("opening: no",),
    made={"time": "now"},
    computer={"doctor": []},
    log="ü\n",
    readme="",
    pixels=(b"\1" * 20,),
)


def test_what_is_written_is_read() -> None:
    assert decode(encode(REPORT)) == REPORT


def test_numbers_that_json_lacks_become_text() -> None:
    features = ({"name": "Gain", "maximum": float("inf"), "value": float("nan")},)
    text = zipfile.ZipFile(io.BytesIO(encode(replace(REPORT, features=features)))).read("camera.json")
    row = json.loads(text, parse_constant=lambda name: pytest.fail(name))["features"][0]
    assert row == {"name": "Gain", "maximum": "inf", "value": "nan"}


def changed(name: str, content: bytes | str, *, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return the report with another member of this name."""
    archive = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(encode(REPORT))) as old, zipfile.ZipFile(archive, "w") as new:
        for each in old.namelist():
            if each != name:
                new.writestr(each, old.read(each))
        new.writestr(name, content, method)
    return archive.getvalue()


def camera(**values: object) -> bytes:
    content = json.loads(zipfile.ZipFile(io.BytesIO(encode(REPORT))).read("camera.json"))
    return changed("camera.json", json.dumps({**content, **values}))


def registers(**row: object) -> bytes:
    whole = {"address": "0x10", "length": 4, "data": "01020304", **row}
    return changed("registers.json", json.dumps({"registers": [whole]}))


BAD = {
    "no zip": b"PK\3\4 and so on",
    "empty": b"",
    "another zip": changed("camera.json", "{}"),
    "a newer version": camera(version=2),
    "info of another kind": camera(info={"uri": 5}),
    "info with more": camera(info={"uri": "sim:", "surprise": "x"}),
    "no info": camera(info=None),
    "unknown layout": camera(chunk_layout="GigE"),
    "list of features": camera(features={"a": 1}),
    "text for JSON": changed("stream.json", "[1, 2"),
    "list for object": changed("stream.json", "[1, 2]"),
    "nested": changed("stream.json", "[" * 100_000),
    "not UTF-8": changed("registers.json", b"\xff\xfe"),
    "short data": registers(data="0102"),
    "no hex": registers(data="xx"),
    "negative address": registers(address="-0x10"),
    "address beyond 64 bits": registers(address="0xFFFFFFFFFFFFFFFF"),
    "huge register": registers(length=1 << 40, data=""),
    "neither data nor failure": changed(
        "registers.json", json.dumps({"registers": [{"address": "0x10", "length": 4}]})
    ),
    "time that is none": registers(ms="NaN"),
    "huge frames": changed(
        "stream.json", json.dumps({"frames": [vars(REPORT.stream.frames[0]) | {"width": 1 << 40}]})
    ),
    "LZMA": changed("registers.json", "{}", method=zipfile.ZIP_LZMA),
}


@every_case("content", BAD.values(), ids=BAD.keys())
def test_a_bad_file_is_refused_in_a_sentence(content: bytes) -> None:
    with pytest.raises(UsageError, match=r"the file (is no|cannot be read as a) ") as error:
        decode(content)
    assert len(str(error.value)) < 300


def test_a_member_that_grows_is_not_unpacked_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_file, "MAX_MEMBER_BYTES", 1 << 16)
    bomb = changed("registers.json", b" " * (1 << 24))
    assert len(bomb) < 1 << 16
    with pytest.raises(UsageError, match="has more than"):
        decode(bomb)


def test_a_file_beyond_the_limit_is_not_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(report_file, "MAX_FILE_BYTES", 100)
    (tmp_path / "a.zip").write_bytes(encode(REPORT))
    with pytest.raises(UsageError, match="too long"):
        report_file.load(tmp_path / "a.zip")


def test_damaged_bytes_raise_nothing_else() -> None:
    good = encode(REPORT)
    chance, refused = random.Random(40), 0
    for _ in range(300):
        damaged = bytearray(good)
        for _ in range(chance.randrange(1, 4)):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        try:
            decode(bytes(damaged[: chance.randrange(len(damaged)) if chance.random() < 0.3 else None]))
        except UsageError:
            refused += 1
    assert refused > 100


def test_names_of_members_lead_nowhere(tmp_path: Path) -> None:
    content = changed("../../evil", "x")
    (tmp_path / "a.zip").write_bytes(content)
    assert report_file.load(tmp_path / "a.zip").info == REPORT.info
    assert [path.name for path in tmp_path.iterdir()] == ["a.zip"]


@pytest.mark.parametrize(
    ("uri", "problem"),
    [
        ("twin:", "write a report's file"),
        ("twin:/nowhere.zip", "no camera report /nowhere"),
        ("twin:/", "folder"),
        ("twin:x.zip?speed=2", "no option speed"),
    ],
)
def test_wrong_uris_are_refused(uri: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        sources.create(uri)
    assert issubclass(MissingFileError, UsageError)


def test_memory_answers_as_recorded_until_it_is_written() -> None:
    recorded = [
        RecordedAccess(0x10, 4, b"\0\0\0\1"),
        RecordedAccess(0x10, 8, b"\0\0\0\2\0\0\0\3"),
        RecordedAccess(0x20, 4, None, 0, "DeviceStatusError", 0x8006, "no"),
    ]
    twin = TwinMemory(recorded)
    assert twin.read(0x10, 4) == b"\0\0\0\1" and twin.read(0x14, 4) == b"\0\0\0\3"
    twin.write(0x10, b"\0\0\0\7")
    assert twin.read(0x10, 8) == b"\0\0\0\7\0\0\0\3"
    for address in (0x20, 0x1E):
        with pytest.raises(DeviceStatusError, match="no"):
            twin.read(address, 4)
    assert twin.read(0x5000, 6) == bytes(6)


def test_a_host_that_writes_everywhere_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "MOST_PAGES", 10)
    twin = TwinMemory(())
    with pytest.raises(DeviceStatusError, match="no memory left"):
        for address in range(0, 1 << 20, 4096):
            twin.write(address, b"\1")


def test_every_call_of_a_device_is_passed_on_while_it_is_recorded() -> None:
    calls = {name for name, value in vars(Device).items() if callable(value) and not name.startswith("_")}
    reports = {"report_event", "report_lost"}  # of the device itself
    assert calls - reports <= vars(RecordedDevice).keys()


def test_a_frame_of_absurd_size_takes_no_memory() -> None:
    frame = replace(REPORT.stream.frames[0], width=1 << 19, height=1 << 19, payload_bytes=1 << 30)
    model = TwinModel(replace(REPORT, description=b"", stream=replace(REPORT.stream, frames=(frame,))))
    plan = model.next_frame(1.0)
    assert plan is not None and plan.payload_bytes <= LARGEST_FRAME


@pytest.mark.parametrize(
    ("switches", "writes"),
    [
        ([(0x10, b"\0\0\0\1", True), (0x14, b"\0\0\0\1", False)], [(0x10, 0x81, True), (0x14, 0x81, False)]),
        # One register for both, with another setting beside them.
        (
            [(0x10, b"\x80\0\0\7", True), (0x10, b"\0\0\0\7", False)],
            [(0x10, 1 << 31, True), (0x10, 3, False)],
        ),
        (
            [(0x10, b"\0\0\0\1", True), (0x10, b"\0\0\0\2", False)],
            [(0x10, 1, True), (0x10, 2, False), (0x10, 4, None)],
        ),
        ([], [(0x10, 1, None)]),
    ],
)
def test_the_write_that_starts_is_recognised(
    switches: list[tuple[int, bytes, bool]], writes: list[tuple[int, int, bool | None]]
) -> None:
    model = TwinModel(replace(REPORT, description=b""))
    model._switches = switches
    for address, value, starts in writes:
        assert model._switched(address, value.to_bytes(4, "big")) is starts
    assert model._switched(0x99, b"\0\0\0\1") is None
