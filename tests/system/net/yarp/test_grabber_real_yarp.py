"""The real YARP's own programs against our ports, and our client against its frame grabber.

Run with a YARP of either version on PATH; the names are served by our own name server.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from grabber_stage import Stage
from grabbergui.core.errors import GrabberError
from grabbergui.net.yarp.client import YarpGrabber
from patience import PATIENCE, until

pytestmark = [
    pytest.mark.yarp,
    pytest.mark.skipif(not shutil.which("yarp"), reason="the program yarp is not on PATH"),
]

Run = Callable[..., str]


@pytest.fixture
def environment(scene: Stage, tmp_path: Path) -> dict[str, str]:
    host, _, port = scene.address.partition(":")
    (tmp_path / "yarp.conf").write_text(f"{host} {port} yarp\n")
    return {**os.environ, "YARP_CONFIG_HOME": str(tmp_path)}


@pytest.fixture
def yarp(environment: dict[str, str]) -> Run:
    """Runs `yarp ARGUMENT…`, with lines to type, and gives what it printed."""

    def run(*arguments: str, typed: str = "") -> str:
        return subprocess.run(
            ["yarp", *arguments],
            env=environment,
            input=typed,
            text=True,
            errors="replace",
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=PATIENCE,
        ).stdout

    return run


def test_our_ports_are_listed_and_answer(scene: Stage, yarp: Run) -> None:
    with scene.share():
        names = yarp("name", "list")
        assert "registration name /grabber ip" in names
        assert "registration name /grabber/rpc ip" in names
        typed = "fgc has feat 8\nfgc set feat 8 5\nfgc get feat 8\nfgc get fea2 8\nfgi get w\n"
        said = [
            line.removeprefix("Response: ") for line in yarp("rpc", "/grabber/rpc", typed=typed).split("\n")
        ]
        wanted = [
            "[fgc] [has] [feat] 1952540006 1",
            "[fgc] [set] 1",
            "[fgc] [feat] [is] 5.0",
            "[fgc] [fea2] [is] 0.0 24.0",
            "[fgi] [w] [is] 168",
        ]
        if "4." in yarp("version").split("version")[-1][:4]:
            # YARP 4.0 cannot read the numbers of 3.x replies; it has its own words.
            typed = "hasFeatureRPC 8\nsetFeature1RPC 8 5.0\ngetFeature1RPC 8\ngetFeature2RPC 8\ngetWidthRPC\n"
            answers = yarp("rpc", "/grabber/rpc", typed=typed).split("\n")
            said = [line.removeprefix("Response: ") for line in answers]
            wanted = ["([ok]) [ok]", "[ok]", "([ok]) 5.0", "([ok]) 0.0 24.0", "([ok]) 168"]
        assert [line for line in said if line in wanted] == wanted


@pytest.mark.parametrize(
    "carrier", ["tcp", "fast_tcp", "udp", "mjpeg", "unix_stream", "fast_tcp+pixels.mono"]
)
def test_yarp_reads_our_images(
    scene: Stage, yarp: Run, environment: dict[str, str], carrier: str, tmp_path: Path
) -> None:
    output = tmp_path / "images"
    with scene.share(), output.open("w") as file:
        reader = subprocess.Popen(["yarp", "read", "/reader"], env=environment, stdout=file, stderr=file)
        try:
            until(lambda: "/reader" in {c.name for c in scene.names.list()}, "the reader's port")
            # A port is registered a moment before it listens.
            until(lambda: "Success" in yarp("connect", "/grabber", "/reader", carrier), "the connection")
            # Over mjpeg the numbers between are those of the reader's own YARP.
            layout = rb"\[mono\] \(1 16800" if "mono" in carrier else rb"\[rgb\] \(3 50400"
            image = re.compile(rb"\[mat\] " + layout + rb" \d+ 168 100\)")
            until(lambda: image.search(output.read_bytes()), "an image")
            yarp("disconnect", "/grabber", "/reader")
        finally:
            reader.kill()
            reader.wait()
    scene.names.unregister("/reader")


@pytest.fixture
def real_server(scene: Stage, environment: dict[str, str], tmp_path: Path) -> Iterator[str]:
    """A frameGrabber_nws_yarp on a fake camera."""
    if not shutil.which("yarpdev"):
        pytest.skip("the program yarpdev is not on PATH")
    command = "yarpdev --device deviceBundler --wrapper_device frameGrabber_nws_yarp"
    options = "--attached_device fakeFrameGrabber --name /real --period 0.03 --width 322 --height 240"
    with (tmp_path / "yarpdev").open("w") as log:
        device = subprocess.Popen(
            [*command.split(), *options.split()], env=environment, stdout=log, stderr=log
        )
    try:
        known = lambda: "/real/rpc" in {contact.name for contact in scene.names.list()}  # noqa: E731
        until(lambda: known() or device.poll() is not None, "the real server's port")
        if device.poll() is not None:
            pytest.skip("this YARP has no deviceBundler, frameGrabber_nws_yarp or fakeFrameGrabber")
        yield "/real"
    finally:
        device.kill()
        device.wait()
        for contact in scene.names.list("/real"):
            scene.names.unregister(contact.name)


@pytest.mark.parametrize("carrier", ["tcp", "fast_tcp", "udp", "mjpeg", "unix_stream"])
def test_we_drive_a_real_server(scene: Stage, real_server: str, carrier: str) -> None:
    remote = YarpGrabber(real_server, nameserver=scene.address, carrier=carrier)
    _open(remote)
    try:
        assert remote.feature("Width").value == 322
        queue = remote.open_queue()
        remote.start()
        first, second = queue.get(PATIENCE), queue.get(PATIENCE)
        assert (first.rgb().shape, first.padding_x) == ((240, 322, 3), 2)
        assert second.frame_id > first.frame_id
        assert remote.write_feature("ReverseX", True).name == "ReverseX"
    finally:
        remote.close()


def _open(remote: YarpGrabber) -> None:
    """The port is registered a moment before it answers, and answers before it has its camera."""

    def answers() -> bool:
        try:
            remote.open()
        except GrabberError:
            return False
        if not remote.has_feature("Width"):
            remote.close()
            return False
        return True

    until(answers, "the real server's answer")
