"""A process that is killed while it loads a description holds up nobody.

GRABBERGUI_KILLS=100 kills a hundred times, as the proof of it needs.
"""

import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui.driver.genapi import loading
from grabbergui.driver.genapi.loading import LARGE_XML
from patience import PROGRAM

KILLS = int(os.environ.get("GRABBERGUI_KILLS", "1"))
LOAD = f"""
import sys
from {loading.__name__} import load
xml = open(sys.argv[1]).read()
print("loading", flush=True)
load(xml)
"""
XML = (Path(__file__).parents[3] / "data" / "genapi" / "test_camera.xml").read_text()
HEAD, TAIL = XML[: XML.rindex("</RegisterDescription>")], "</RegisterDescription>"


@pytest.fixture(scope="module")
def description(tmp_path_factory) -> Path:
    """One of 9,000 nodes."""
    nodes = "".join(
        f'<Integer Name="Extra{i}"><ToolTip>One of many</ToolTip><Value>{i}</Value></Integer>'
        for i in range(9000)
    )
    path: Path = tmp_path_factory.mktemp("killed") / "large.xml"
    path.write_text(HEAD + nodes + TAIL)
    assert path.stat().st_size > LARGE_XML
    return path


def started(description: Path) -> "subprocess.Popen[str]":
    process = subprocess.Popen(
        [sys.executable, "-c", LOAD, str(description)],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "loading\n"
    return process


@pytest.mark.parametrize("kill", range(KILLS))
def test_the_next_load_does_not_wait_for_the_dead(description, kill):
    source = random.Random(kill)
    victim = started(description)
    try:
        victim.wait(source.uniform(0, 0.6))
    except subprocess.TimeoutExpired:
        # Alone, or with the process that parses for it.
        (os.killpg if source.random() < 0.5 else os.kill)(victim.pid, signal.SIGKILL)
    victim.communicate()

    with started(description) as survivor:
        assert survivor.wait(timeout=PROGRAM) == 0
