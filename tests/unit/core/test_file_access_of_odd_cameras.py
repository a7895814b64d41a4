"""Cameras whose file access lacks what SFNC leaves open, moves less than requested, or reports nonsense."""

from contextlib import contextmanager
from itertools import pairwise

import pytest

from fakes import ScriptedGrabber
from grabbergui.core import file_access
from grabbergui.core.errors import CameraFileError
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.file_access import read_file, write_file

BLOCK = 4
"Bytes of FileAccessBuffer."


def choice(name, *names):
    entries = tuple(EnumEntry(entry) for entry in names)
    return Feature(
        name=name,
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_WRITE,
        value=names[0],
        entries=entries,
    )


def number(name, value=0, maximum=None):
    return Feature(
        name=name, kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=value, maximum=maximum
    )


class FileCamera(ScriptedGrabber):
    """A camera of one file. `moved` says what it reports of so many bytes that it can move."""

    def __init__(self, content=b"", *, reports=(), readable=True, moved=lambda possible: possible):
        self.content, self.buffer, self.moved = bytearray(content), b"", moved
        self.events = []
        "Operations, and the ends of the turns in which other callers wait."
        modes = ["Write", "Read"] if readable else ["Write"]
        optional = {
            "FileSize": number("FileSize", len(content)),
            "FileOperationStatus": choice("FileOperationStatus", "Success", "Failure"),
            "FileOperationResult": number("FileOperationResult"),
        }
        super().__init__(
            [
                choice("FileSelector", "Table"),
                choice("FileOpenMode", *modes),
                choice("FileOperationSelector", "Open", "Close", "Read", "Write", "Delete"),
                Feature(name="FileOperationExecute", kind=FeatureKind.COMMAND, access=AccessMode.WRITE_ONLY),
                number("FileAccessOffset"),
                number("FileAccessLength", maximum=BLOCK),
                *(optional[name] for name in reports),
            ]
        )

    @contextmanager
    def exclusive(self, selectors=()):
        with super().exclusive(selectors):
            yield
        self.events.append("turn")

    @property
    def operations(self):
        return [event for event in self.events if event != "turn"]

    def execute(self, name):
        super().execute(name)
        operation = self.known["FileOperationSelector"].value
        self.events.append(operation)
        at, length = (self.known[name].value for name in ("FileAccessOffset", "FileAccessLength"))
        moved = 0
        if operation == "Read":
            self.buffer = bytes(self.content[at : at + length])
            moved = self.moved(len(self.buffer))
        elif operation == "Write":
            moved = self.moved(length)
            self.content[at : at + moved] = self.buffer[:moved]
        if self.has_feature("FileOperationResult"):
            self.set("FileOperationResult", moved)

    def register_length(self, name):
        return BLOCK

    def read_register(self, name, length):
        return self.buffer[:length]

    def write_register(self, name, content):
        self.buffer = bytes(content)


RESULT, SIZE = "FileOperationResult", "FileSize"


@pytest.mark.parametrize("length", [0, 3, 4, 8, 10])
def test_a_file_of_unknown_size_ends_with_a_short_or_an_empty_block(length):
    content = bytes(range(length))
    camera = FileCamera(content, reports=[RESULT])
    assert read_file(camera, "Table") == content
    assert camera.operations == ["Open", *["Read"] * (length // BLOCK + 1), "Close"]


def test_a_camera_that_moves_less_than_requested_moves_the_whole_file_by_and_by():
    content = bytes(range(10))
    sparing = FileCamera(content, reports=[RESULT, SIZE], moved=lambda possible: min(possible, 3))
    assert read_file(sparing, "Table") == content
    assert sparing.operations.count("Read") == 4

    sparing.content.clear()
    sparing.set(SIZE, 10)
    assert write_file(sparing, "Table", content[::-1]).verified
    assert sparing.content == content[::-1]


def test_a_camera_that_reports_no_results_is_taken_to_have_moved_everything():
    camera = FileCamera(bytes(10), reports=[SIZE])
    assert write_file(camera, "Table", bytes(range(10))).verified
    assert camera.content == bytes(range(10))


def test_a_file_that_cannot_be_read_back_is_not_verified():
    camera, seen = FileCamera(reports=[RESULT], readable=False), []
    written = write_file(camera, "Table", b"12345", progress=lambda done, of: seen.append((done, of)))
    assert (written.size, written.verified) == (5, False)
    assert camera.content == b"12345"
    assert seen == [(4, 10), (5, 10), (10, 10)]


def test_a_file_that_is_shorter_than_its_size_is_an_error():
    camera = FileCamera(bytes(10), reports=[RESULT, SIZE])
    del camera.content[6:]
    with pytest.raises(CameraFileError, match=r"reading Table: the camera reports 10 bytes and delivered 6$"):
        read_file(camera, "Table")


@pytest.mark.parametrize("reported", [-1, 99])
def test_an_impossible_number_of_bytes_is_an_error(reported):
    camera = FileCamera(bytes(8), reports=[RESULT], moved=lambda possible: reported)
    with pytest.raises(CameraFileError, match=rf"the camera reports {reported} bytes, 4 were requested"):
        read_file(camera, "Table")


def test_a_camera_that_accepts_no_byte_ends_the_upload():
    camera = FileCamera(reports=[RESULT], moved=lambda possible: 0)
    with pytest.raises(CameraFileError, match="writing Table: the camera accepted no byte"):
        write_file(camera, "Table", b"12345")


def test_a_file_without_an_end_is_given_up(monkeypatch):
    monkeypatch.setattr(file_access, "LARGEST", 10)
    camera = FileCamera(bytes(1000), reports=[RESULT])
    with pytest.raises(CameraFileError, match="Table does not end after 10 bytes"):
        read_file(camera, "Table")


def test_a_transfer_that_failed_closes_the_file_and_keeps_its_error():
    camera = FileCamera(bytes(8), reports=[RESULT, "FileOperationStatus"], moved=lambda possible: -1)
    camera.on_write = lambda name, value: (
        camera.set("FileOperationStatus", "Failure") or value if value == "Close" else value
    )
    with pytest.raises(CameraFileError, match="reports -1 bytes"):
        read_file(camera, "Table")
    assert camera.operations == ["Open", "Read", "Close"]


def test_other_callers_get_their_turn_between_the_blocks_of_a_transfer(monkeypatch):
    monkeypatch.setattr(file_access, "TURN", 1e-6)  # shorter than a block
    camera = FileCamera(bytes(20), reports=[RESULT, SIZE])
    read_file(camera, "Table")
    reads = [index for index, event in enumerate(camera.events) if event == "Read"]
    assert len(reads) == 5
    assert all("turn" in camera.events[one:other] for one, other in pairwise(reads))
