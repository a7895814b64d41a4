"""Every command that prints text, with a camera, a search and files whose every text is hostile."""

import io
import json
import re
import sys
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from grabbergui import doctor, sources
from grabbergui.cli import COMMANDS, main
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.uri import SourceUri
from grabbergui.doctor.findings import Finding, Level
from marked_camera import CONTROL, MORE_CONTROL, marked_camera, marked_info

NAME = "N\x1b]0;t\x07\x08\r"
"""Fits into the camera's string registers."""
REFUSED = "refuse:"
"""A source that cannot be opened, for a reason that its peer gave."""

SHOWN = {
    "list": [["list"]],
    "doctor": [["doctor"]],
    "features": [["features", "sim:"]],
    "get": [["get", "sim:", "DeviceUserID", "ExposureTime"], ["get", "sim:", "Nothing\x1b[31m"]],
    "set": [
        ["set", "sim:", f"DeviceUserID={NAME}", "ExposureTime=5000"],
        ["set", "sim:", "ExposureTime=0"],
        ["set", "sim:", "PixelFormat=\x9b\u202e"],
    ],
    "run": [["run", "sim:", "Nothing\x1b"]],
    "save": [["save", "sim:", "new\x1b[31m\n.yaml"]],
    "load": [["load", "sim:", "hostile.yaml"], ["load", "sim:", "hostile.txt"]],
    "diff": [["diff", "sim:", "hostile.yaml"], ["diff", "hostile.yaml", "hostile.txt"]],
    "files": [["files", "sim:"], ["files", "sim:", "get", "No\x1bFile"]],
    "grab": [["grab", "sim:", "-n", "1"], ["grab", f"{REFUSED}"]],
    "record": [["record", "sim:", "--out", "rec\x1b[31m", "-n", "1"]],
    "events": [["events", "sim:", "Nothing\x1b"]],
    "terminal": [["terminal", "sim:"]],
    "report": [["report", "sim:", "--frames", "0", "--out", "a\x1b.zip"]],
}
"""Command lines of which each command prints what strangers wrote."""
COMMON = {
    "serve": [["serve", REFUSED, "--terminal"]],
    "calibrate": [["calibrate", REFUSED]],
    "trigger-group": [["trigger-group", "1", REFUSED]],
    "rig": [["rig", "check", "hostile.yaml"], ["rig", "new", "rig\x1b.yaml", "a=sim:", "b=x\x1b:"]],
    "gui": [["gui", "--theme", "d\x1b[31m"]],
}
"""Command lines of commands that print little, at least for an error."""
OWN_WORDS = {
    "persistent-ip": "needs a GigE Vision camera; prints a line of its properties, by the same writer",
    "setup": "prints the paths that it writes",
    "paths": "prints paths of the installation",
    "force-ip": "prints its own arguments",
    "yarp-server": "prints its own address",
    "simulate": "prints its own options, and simulates no camera but its own",
}
"""Commands that print nothing of a stranger."""


class Terminal(io.TextIOWrapper):
    """A stream whose bytes can be looked at."""

    def __init__(self):
        super().__init__(io.BytesIO(), encoding="utf-8", errors="surrogateescape", write_through=True)

    @property
    def text(self):
        return self.buffer.getvalue().decode("utf-8", "surrogateescape")


@pytest.fixture
def hostile(monkeypatch, tmp_path):
    """The world of a stranger; returns what runs a command, and gives its exit code, stdout and stderr."""
    monkeypatch.chdir(tmp_path)
    text = "\u202eA\u200bB"  # a settings file has no control characters
    yaml = f'features:\n  ExposureTime: {text}\n  No{text}: 5\n  DeviceUserID: "{text}"\n'
    (tmp_path / "hostile.yaml").write_text(yaml, "utf-8")
    (tmp_path / "hostile.txt").write_text(
        f"# {{05D8C294-F295-4dfb-9D01-096BD04049F4}}\nNo{text}\t5\n{text}\n", "utf-8"
    )

    def create(uri):
        if str(uri).startswith(REFUSED):
            raise SourceUnavailableError(f"the peer says {MORE_CONTROL}")
        return marked_camera(SourceUri.parse(str(uri)), CONTROL, NAME)

    monkeypatch.setattr(sources, "create", create)
    monkeypatch.setattr(sources, "discover", lambda *_: [marked_info(MORE_CONTROL, f"sim:{MORE_CONTROL}")])
    finding = Finding(Level.PROBLEM, f"seen {MORE_CONTROL}", f"do {MORE_CONTROL}")
    monkeypatch.setattr(doctor, "check", lambda: [finding])

    def run(arguments, typed=""):
        out, err = Terminal(), Terminal()
        with monkeypatch.context() as context:
            context.setattr(sys, "stdout", out)
            context.setattr(sys, "stderr", err)
            if typed:
                (tmp_path / "typed").write_text(typed, "utf-8")
            with (tmp_path / "typed").open() if typed else nullcontext(sys.stdin) as stdin:
                context.setattr(sys, "stdin", stdin)
                code = main(arguments)
        return SimpleNamespace(code=code, out=out.text, err=err.text)

    return run


def check_printable(text):
    lines = text.split("\n")
    assert lines.pop() == ""
    for line in lines:
        assert line.isprintable(), ascii(line)
        assert not line.startswith("⁂"), f"a line of the camera's own: {line}"


def test_every_command_is_tried():
    assert SHOWN.keys() | COMMON.keys() | OWN_WORDS.keys() == set(COMMANDS)


@pytest.mark.parametrize("command", SHOWN | COMMON)
def test_a_stranger_does_not_control_the_terminal(hostile, command):
    marks = ""
    for arguments in (SHOWN | COMMON)[command]:
        typed = (
            "get DeviceUserID\nlist\nset PixelFormat \x9b\u202e\nset ExposureTime 0\nwatch DeviceUserID 0.1\n"
        )
        done = hostile(arguments, typed if command == "terminal" else "")
        check_printable(done.out)
        check_printable(done.err)
        marks += done.out + done.err
    assert re.search(r"\\x1b|\\x9b|\\u202e", marks), f"nothing of the stranger was printed: {marks}"


def test_json_is_exact(hostile):
    listed = hostile(["list", "--json"])
    assert json.loads(listed.out)[0]["vendor"] == f"{MORE_CONTROL}vendor"
    check_printable(listed.out)
    value = hostile(["get", "sim:", "DeviceUserID", "--json"])
    assert json.loads(value.out) == {"DeviceUserID": NAME}
    check_printable(value.out)
