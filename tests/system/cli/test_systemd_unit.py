"""The systemd unit that we ship, read by systemd itself."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui.cli import command_line

UNIT = Path(__file__).parents[3] / "resources" / "systemd" / "grabbergui.service"
PROGRAM = "/opt/grabbergui/.venv/bin/grabbergui"


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_finds_nothing_wrong_with_it(tmp_path):
    unit = tmp_path / UNIT.name
    unit.write_text(UNIT.read_text("utf-8").replace(PROGRAM, sys.executable), "utf-8")

    checked = subprocess.run(["systemd-analyze", "verify", str(unit)], capture_output=True, text=True)

    complaints = [line for line in checked.stderr.splitlines() if UNIT.name in line]
    assert not complaints and checked.returncode == 0


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_a_stranger_who_gets_in_can_do_little(tmp_path):
    """SECURITY.md has the figure, 1.8."""
    command = ["systemd-analyze", "security", "--offline=true", "--threshold=18", "--no-pager", str(UNIT)]
    checked = subprocess.run(command, capture_output=True, text=True)
    if "unrecognized option" in checked.stderr:
        pytest.skip("this systemd cannot judge a unit that is not installed")

    assert checked.returncode == 0, checked.stdout.splitlines()[-1:] + checked.stderr.splitlines()[-1:]


def test_its_command_is_one_of_ours():
    command = re.search(rf"^ExecStart={PROGRAM} (.*)$", UNIT.read_text("utf-8"), re.MULTILINE)[1]
    parser = command_line()

    options = parser.parse_args(command.split())

    assert (options.file, options.log_format) == ("/etc/grabbergui/camera.ini", "json")
