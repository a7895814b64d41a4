"""Files from outside: only regular ones are opened, nothing hangs, and no place opens them otherwise."""

import ast
import os
import re
import stat
import sys
import threading
from pathlib import Path

import pytest

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.regular_files import check_regular, open_regular, read_bounded
from grabbergui.driver import description as descriptions
from grabbergui.driver.description import FOLDER_VARIABLE
from patience import PATIENCE

PACKAGE = Path(__file__).parents[3] / "grabbergui"

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="it has no FIFOs")


def fifo(folder: Path, name: str) -> Path:
    os.mkfifo(path := folder / name)
    return path


def test_a_file_is_read_up_to_its_limit(tmp_path):
    (path := tmp_path / "file").write_bytes(b"12345")
    assert read_bounded(path, 5, "thing") == b"12345"
    with pytest.raises(UsageError, match="too long for a thing: larger than 0 KiB"):
        read_bounded(path, 4, "thing")
    with open_regular(path) as file:
        assert os.get_blocking(file.fileno()) is False and file.read() == b"12345"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda folder: fifo(folder, "pipe"), r"a pipe \(FIFO\)"),
        (lambda folder: Path("/dev/zero"), "a device"),
        (lambda folder: linked(folder, "/dev/zero"), "a device"),
        (lambda folder: linked(folder, str(fifo(folder, "pipe"))), r"a pipe \(FIFO\)"),
    ],
    ids=["pipe", "device", "link to a device", "link to a pipe"],
)
def test_anything_but_a_regular_file_is_refused_by_its_kind(tmp_path, make, message):
    path = make(tmp_path)
    for read in (open_regular, check_regular, lambda path: read_bounded(path, 9, "thing")):
        with pytest.raises(UsageError, match=f"{path} is {message}, not a regular file"):
            read(path)


def linked(folder: Path, target: str) -> Path:
    (path := folder / "link").symlink_to(target)
    return path


def test_a_folder_is_an_error_of_the_system(tmp_path):
    with pytest.raises(IsADirectoryError, match=str(tmp_path)):
        open_regular(tmp_path)


def test_a_link_to_a_file_is_followed(tmp_path):
    (path := tmp_path / "file").write_bytes(b"content")
    assert read_bounded(linked(tmp_path, str(path)), 9, "thing") == b"content"


def test_a_name_that_is_exchanged_between_check_and_opening_does_not_hang(tmp_path, monkeypatch):
    path = fifo(tmp_path, "pipe")
    regular = Path(__file__).stat()
    monkeypatch.setattr(Path, "stat", lambda self, **_: regular)
    before = len(list(Path("/proc/self/fd").iterdir()))
    with pytest.raises(UsageError, match="pipe"):
        open_regular(path)
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def settings(path):
    from grabbergui.models.settings import files

    files.load(path)


def calibration(path):
    from grabbergui.calibration import camera_info

    camera_info.load(path)


def calibration_in_use(path):
    from grabbergui import sources
    from grabbergui.calibration.fitting import FittedCalibration

    FittedCalibration(sources.create("sim:"), path).keep(Calibration.from_field_of_view(64, 48))


def table(path):
    from grabbergui.core.lookup_table import LutShape, load_table

    load_table(path, LutShape(256, 255, whole=False))


def script(path):
    pytest.importorskip("PyQt5")
    from grabbergui.ui.run.scripting import load_script

    load_script(path)


def recording(path):
    from grabbergui.recording.opening import open_recording

    open_recording(path)


def image(path):
    from grabbergui.recording.opening import open_recording

    open_recording(path.parent).frame(0, 0)


def notes(path):
    from grabbergui.recording.notes import read_notes

    list(read_notes(path))


def ini(path):
    from grabbergui.config.ini_files import read_ini

    read_ini(path)


def token(path):
    from grabbergui.cli.metrics import read_token

    read_token(str(path))


def description(path):

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(path.parent))
        descriptions.read_file(path)


def upload(path):
    from grabbergui.core.file_access import content_of

    content_of(path)


READERS = [
    (settings, "s.yaml"),
    (settings, "s.pfs"),
    (calibration, "c.yaml"),
    (calibration_in_use, "c.yaml"),
    (table, "t.csv"),
    (table, "t.bin"),
    (script, "s.py"),
    (recording, "r.mcap"),
    (recording, "r.mp4"),
    (recording, "r.avi"),
    (image, "0001.png"),
    (notes, "frames.jsonl"),
    (ini, "s.ini"),
    (token, "token"),
    (description, "d.xml"),
    (upload, "u.bin"),
]


@pytest.mark.parametrize(("read", "name"), READERS, ids=lambda value: getattr(value, "__name__", value))
def test_every_reader_refuses_a_pipe_at_once_and_says_so(tmp_path, read, name):
    path = fifo(tmp_path, name)
    caught: list[BaseException] = []

    def work() -> None:
        try:
            read(path)
        except BaseException as error:
            caught.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(PATIENCE)
    if thread.is_alive():
        os.close(os.open(path, os.O_WRONLY | os.O_NONBLOCK))  # lets it end
        pytest.fail(f"{name} hangs")
    assert caught and isinstance(caught[0], GrabberError) and "pipe (FIFO)" in str(caught[0])


OPENED_OTHERWISE = {
    "core/regular_files.py": "the owner",
    "core/shared_folder.py": "the owner for folders of several users",
    "core/environment.py": "writes a draft beside the file",
    "__main__.py": "/dev/null and its own streams",
    "cli/__init__.py": "/dev/null and its own streams",
    "ui/theme.py": "shipped with the program",
    "ui/views/help_views.py": "shipped with the program",
    "driver/sim/camera_xml.py": "shipped with the program",
    "driver/sim/gige/registers.py": "shipped with the program",
    "setup/completion.py": "the program's own cache and files shipped with it",
    "setup/desktop_entry.py": "shipped with the program",
    "setup/udev_rule.py": "shipped with the program",
    "setup/ros2.py": "ROS's own files",
    "setup/seen.py": "the program's own cache, and a file shipped with it",
    "report/stand_ins.py": "/sys",
    "driver/genapi/parse_cache.py": "the program's own cache, a folder that nobody else may write to",
    "doctor/gige.py": "/proc",
    "models/other_program.py": "/proc",
    "doctor/usb.py": "/sys",
    "net/ros2/runtime.py": "a profile of the user",
    "net/ros2/shared_memory.py": "/proc",
    "driver/u3v/enumeration.py": "/sys",
    "driver/u3v/users.py": "/proc",
    "driver/sim/u3v/gadget.py": "/sys and /dev",
    "driver/sim/u3v/virtual_host.py": "/sys",
    "driver/v4l2/finding.py": "/dev and /sys",
    "driver/v4l2/video.py": "/dev",
}
"File of the package: why it opens files without `core/regular_files.py`."

_READING = {
    "read_text",
    "read_bytes",
    "fromfile",
    "imread",
    "memmap",
    "loadtxt",
    "genfromtxt",
    "VideoCapture",
}
_MODES = {"r", "rb", "rt", "r+", "r+b"}


_WORTH_PARSING = re.compile(rf"\bopen\((?!\)|[Aa]ccess)|{'|'.join(_READING)}")


def opens(tree):
    """Yield the calls that open a file by its name."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        match node.func:
            case ast.Name(id="open"):
                yield node
            case ast.Attribute(attr=attr) if attr in _READING and not _of_register(node):
                yield node
            case ast.Attribute(attr="open", value=ast.Name(id="os" | "io")):
                yield node
            case ast.Attribute(attr="open") if _has_mode(node):
                yield node


def _of_register(node):
    """Whether a call of `read_text` has a place as its argument, rather than an encoding."""
    return node.func.attr == "read_text" and any(not isinstance(each, ast.Constant) for each in node.args)


def _has_mode(node):
    """Whether a call opens a file for reading: `path.open("rb")`, `path.open(encoding="utf-8")`."""
    mode = node.args[0] if node.args else None
    if isinstance(mode, ast.Constant):
        return mode.value in _MODES
    return any(keyword.arg in ("encoding", "mode") for keyword in node.keywords)


def test_no_file_of_the_package_opens_files_otherwise():
    found = {}
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text("utf-8")
        if _WORTH_PARSING.search(text) and (lines := [node.lineno for node in opens(ast.parse(text))]):
            found[path.relative_to(PACKAGE).as_posix()] = lines
    assert {name: lines for name, lines in found.items() if name not in OPENED_OTHERWISE} == {}
    assert OPENED_OTHERWISE.keys() - found.keys() == set()


def test_the_search_finds_every_form():
    text = (
        "open(p)\nos.open(p, 0)\np.open('rb')\np.read_text()\np.read_bytes()\nnp.fromfile(p)\ncv2.imread(p)"
    )
    assert [node.lineno for node in opens(ast.parse(text))] == [1, 2, 3, 4, 5, 6, 7]
    assert not list(opens(ast.parse("camera.open()\ncamera.open(Access.CONTROL)\nself._open(x)")))


def test_the_mode_is_that_of_a_regular_file(tmp_path):
    (path := tmp_path / "file").touch()
    with open_regular(path) as file:
        assert stat.S_ISREG(os.fstat(file.fileno()).st_mode)


@pytest.mark.parametrize(("most", "limit"), [(1 << 20, "1 MiB"), (3 << 20, "3 MiB"), (5 << 10, "5 KiB")])
def test_the_limit_of_a_file_is_named(tmp_path, most, limit):
    path = tmp_path / "large"
    path.write_bytes(bytes(most))
    assert len(read_bounded(path, most, "table")) == most
    path.write_bytes(bytes(most + 1))
    with pytest.raises(UsageError, match=limit):
        read_bounded(path, most, "table")
