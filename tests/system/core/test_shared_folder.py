"""Folders that other users can write to: files there are opened without waiting, and only one's own."""

import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui.core import shared_folder
from patience import PROGRAM

PACKAGE = Path(shared_folder.__file__).parents[1]


def _socket(path):
    socket.socket(socket.AF_UNIX).bind(str(path))


@pytest.mark.parametrize(
    ("make", "kind"),
    [
        (os.mkfifo, "a pipe (FIFO)"),
        (_socket, "a socket"),
        (lambda path: path.symlink_to(__file__), "a link"),
        (Path.mkdir, "a folder"),
    ],
    ids=["FIFO", "socket", "link", "folder"],
)
@pytest.mark.filterwarnings("ignore:unclosed:ResourceWarning")
def test_anything_else_is_refused_without_waiting(make, kind, tmp_path):
    path = tmp_path / "name"
    make(path)
    with pytest.raises(PermissionError, match=re.escape(kind)), shared_folder.opened(path, of_others=True):
        pass
    assert shared_folder.foreign(path, of_others=True) == kind


WATCHED = """
import json, os, stat, sys

opened, made = [], set()

def watch(event, arguments):
    if event == "os.mkdir":  # fails if there is anything: what was made belongs to the program
        made.add(os.fspath(arguments[0]))
    if event == "open" and isinstance(arguments[0], (str, bytes)):
        path, flags = os.path.abspath(os.fsdecode(arguments[0])), arguments[2]
        if path not in made and os.path.dirname(path) in folders and not flags & os.O_EXCL:
            opened.append((path, flags))

folders = sys.argv[1:]
sys.addaudithook(watch)
from grabbergui.cli import main
from grabbergui.core import shared_folder
from grabbergui.driver.genapi import parse_cache
from grabbergui.net.ros2 import shared_memory
from pathlib import Path
shared_folder.MEMORY = parse_cache.MEMORY = Path(folders[1])
with parse_cache.parsed(sys.stdin.read()):
    pass
memory = Path(folders[1])
shared_memory.reason_against(memory)
shared_memory.clear(shared_memory.leftovers(memory))
main(["get", "sim:", "Gain"])
print(json.dumps(opened))
"""


def test_every_path_in_a_shared_folder_is_opened_so(tmp_path):
    """Python reports each `open`. Whatever is expected there is there, so that it is opened."""
    temporary, memory = tmp_path / "tmp", tmp_path / "shm"
    for folder in (temporary, memory):
        folder.mkdir()
    (temporary / "grabbergui-description-0").mkdir()
    os.mkfifo(temporary / "grabbergui-description-1")
    for name in ("fastdds_0123456789abcdef", "fastdds_0123456789abcdef_el"):
        (memory / name).touch()
        os.utime(memory / name, (0, 0))
    for name in ("fastdds_port7411_el", "fastdds_port7411_sl"):
        os.mkfifo(memory / name)
    run = subprocess.run(
        [sys.executable, "-c", WATCHED, str(temporary), str(memory)],
        input=(PACKAGE / "driver/sim/camera.xml").read_text("utf-8"),
        env={**os.environ, "TMPDIR": str(temporary)},
        capture_output=True,
        text=True,
        timeout=PROGRAM,
    )
    assert run.returncode == 0, run.stderr
    opened = json.loads(run.stdout.splitlines()[-1])
    assert {Path(path).name for path, _ in opened} >= {
        "grabbergui-description-0",
        "fastdds_0123456789abcdef_el",
    }
    safe = os.O_NOFOLLOW | os.O_NONBLOCK
    assert not [path for path, flags in opened if flags & safe != safe]
