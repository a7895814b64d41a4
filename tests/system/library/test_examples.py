"""Every program of examples/ runs as it is, is short, and prints what its text promises."""

from __future__ import annotations

import importlib
import runpy
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import grabbergui
from grabbergui import sources
from grabbergui.library import live_view
from grabbergui.library.live_view import NotebookPanel
from patience import PATIENCE, PROGRAM, until

EXAMPLES = Path(__file__).parents[3] / "examples"
SMALL = "sim:?width=320&height=240&fps=60&exposure=5000"
MOST_LINES = 35

Run = Callable[..., str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)

    def run(name: str, *arguments: str) -> str:
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
        return capsys.readouterr().out

    return run


def test_every_example_is_short_and_says_how_to_start_it() -> None:
    programs = sorted(EXAMPLES.glob("*.py"))
    assert len(programs) >= 12
    for program in programs:
        text = program.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= MOST_LINES, program.name
        assert f"python {program.name}" in text.split('"""')[1], program.name


@pytest.mark.parametrize(
    ("name", "arguments", "printed", "made"),
    [
        ("one_image", [SMALL], "320x240 Mono8", "image.png"),
        ("hdr_bracket", [SMALL], "merged", "hdr.png"),
        ("time_lapse", [SMALL, "0.05", "3"], "lapse-00002.png", "lapse-00002.png"),
        ("software_trigger", [SMALL], "after the call", None),
        ("two_cameras", [SMALL, SMALL], "apart", "both.png"),
        ("events", [SMALL], "ExposureEnd", None),
        ("chunks", [SMALL], "'ExposureTime'", None),
        ("reconnecting", [SMALL, "0.3"], "frame", None),
        ("mcap_out_and_in", [SMALL], "30 frames, 0 dropped", "recording.mcap"),
    ],
)
def test_it_runs(
    run: Run, tmp_path: Path, name: str, arguments: list[str], printed: str, made: str | None
) -> None:
    assert printed in run(name, *arguments)
    assert made is None or (tmp_path / made).stat().st_size > 0


def test_settings_from_a_file(run: Run) -> None:
    with pytest.raises(SystemExit) as ended:
        run("settings_from_file", SMALL)
    assert ended.value.code == 0


@pytest.fixture
def pyplot() -> Any:
    """Matplotlib without windows: beside a QApplication it would take Qt, and wait until they are closed."""
    pytest.importorskip("matplotlib").use("Agg")
    return importlib.import_module("matplotlib.pyplot")


def test_a_live_view_without_a_frame_leaves_no_figure(pyplot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_view, "FIRST_FRAME", 0.05)
    with grabbergui.open("sim:?width=64&height=48") as camera:
        camera["TriggerMode"] = "On"
        before = pyplot.get_fignums()
        with pytest.raises(grabbergui.FrameTimeoutError):
            grabbergui.live_view(camera)
        assert pyplot.get_fignums() == before


def test_matplotlib(run: Run, pyplot: Any) -> None:
    before = {*pyplot.get_fignums()}
    run("matplotlib_live", SMALL)
    (figure,) = map(pyplot.figure, {*pyplot.get_fignums()} - before)
    assert figure.axes[0].images[0].get_array().shape == (240, 320, 3)
    pyplot.close(figure)


class Widgets:
    """Stands in for ipywidgets: every widget keeps its arguments and the functions that observe it."""

    def __getattr__(self, kind: str) -> Callable[..., SimpleNamespace]:
        def make(*children: object, **arguments: object) -> SimpleNamespace:
            widget = SimpleNamespace(
                kind=kind, children=children, observers=[], **{"value": None, **arguments}
            )
            widget.observe = lambda function, name: widget.observers.append(function)
            return widget

        return make


def test_the_panel_of_a_notebook_shows_frames_and_sets_the_camera() -> None:
    with grabbergui.open(SMALL) as camera:
        panel = NotebookPanel(camera, Widgets())
        try:
            image, exposure, gain, status = panel.widget.children[0]
            assert [image.kind, exposure.kind, gain.kind] == ["Image", "FloatLogSlider", "FloatSlider"]
            until(lambda: (image.value or b"").startswith(b"\xff\xd8\xff"))
            gain.observers[0]({"new": 6.0})
            assert camera.gain == 6.0 and status.value == "Gain = 6.0"
            gain.observers[0]({"new": 99.0})
            assert "allowed" in status.value
        finally:
            panel.close()


def test_yarp(run: Run) -> None:
    serving = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "serve", SMALL, "--yarp", "/example", "--with-name-server"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        assert serving.stdout is not None
        until(lambda: sources.discover_kind("yarp", 0.5), "the server", PROGRAM)
        assert "gain is now 6.0" in run("yarp_get_and_set", "yarp:/example")
    finally:
        serving.terminate()
        serving.communicate(timeout=PROGRAM)


def test_a_browser_gets_images(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    serving = subprocess.Popen(
        [sys.executable, str(EXAMPLES / "asyncio_web_stream.py"), SMALL, str(port)],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
    )
    try:

        def connected() -> socket.socket | None:
            try:
                return socket.create_connection(("127.0.0.1", port), 1.0)
            except OSError:
                return None

        for leaves_first in (True, False):
            with until(connected, "the web stream", PROGRAM) as browser:
                browser.settimeout(PATIENCE)
                browser.sendall(b"GET / HTTP/1.0\r\n\r\n")
                received = b""
                while received.count(b"\xff\xd8\xff") < 3:
                    received += browser.recv(1 << 16)
                assert received.startswith(b"HTTP/1.0 200 OK") and b"image/jpeg" in received
                if not leaves_first:
                    serving.send_signal(signal.SIGINT)
                    assert serving.communicate(timeout=PROGRAM)[1] == b""
                    assert serving.returncode == 0
    finally:
        serving.kill()
        serving.communicate()


def test_the_notebook_runs(tmp_path: Path) -> None:
    client = pytest.importorskip("nbclient")
    notebook = pytest.importorskip("nbformat").read(EXAMPLES / "tune_a_camera.ipynb", as_version=4)
    executed = client.NotebookClient(
        notebook, timeout=PROGRAM, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in executed.cells for output in cell.get("outputs", ())]
    shown = [kind for output in outputs for kind in output.get("data", {})]
    assert shown.count("image/png") == 2
    assert "application/vnd.jupyter.widget-view+json" in shown
