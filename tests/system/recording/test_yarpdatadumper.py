"""What YARP's own recorder makes of our images is played, whatever kind of images it writes."""

import itertools
import os
import shutil
import subprocess
from contextlib import ExitStack, closing, contextmanager

import numpy as np
import pytest

from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.ports import OutputPort
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.recording.opening import open_recording
from listening import listens
from patience import until

pytestmark = [
    pytest.mark.yarp,
    pytest.mark.skipif(not shutil.which("yarpdatadumper"), reason="yarpdatadumper is not on the PATH"),
]
FRAMES = 3
KINDS = (
    ("rgb", "image", ".ppm", 0),
    ("rgb", "image_png", ".png", 0),
    ("rgb", "image_jpg", ".jpg", 20),
    ("mono", "image", ".pgm", 0),
    ("dec", "depth", ".float", 0),
    ("dec", "depth_compressed", ".floatzip", 0),
)
"""Pixel code, type of data to be dumped, suffix of the files, and by how much a sample may differ."""


@pytest.fixture
def names(tmp_path):
    with NameServer(port=0) as server:
        (tmp_path / "yarp.conf").write_text(f"127.0.0.1 {server.port_number} yarp\n")
        yield NameClient(server.contact)


@contextmanager
def dumper(folder, name, kind, source):
    """Records from a port into a folder, whose files are complete when it has ended."""
    # It takes the folder as one below its own, and no number for a name.
    options = ["--name", name, "--dir", folder.name, "--type", kind, "--connect", source]
    with subprocess.Popen(
        ["yarpdatadumper", *options],
        cwd=folder.parent,
        env={**os.environ, "YARP_CONFIG_HOME": str(folder.parent), "YARP_FORWARD_LOG_ENABLE": "0"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        try:
            yield
        finally:
            process.terminate()


def test_its_folders_are_played_with_stamps_and_pixels(names, tmp_path):
    """All kinds at once, as it writes its files every ten seconds only."""
    columns = np.linspace(20, 200, 64).reshape(1, 64)
    images = {
        "rgb": np.broadcast_to(columns[..., None], (48, 64, 3)).astype(np.uint8),
        "mono": np.broadcast_to(columns, (48, 64)).astype(np.uint8),
        "dec": np.broadcast_to(columns / 100, (48, 64)).astype(np.float32),
    }
    with ExitStack() as stack:
        outputs = {code: stack.enter_context(OutputPort(f"/{code}", names)) for code in images}
        for number, (code, kind, _, _) in enumerate(KINDS):
            stack.enter_context(dumper(tmp_path / f"dump{number}", f"/dump{number}", kind, f"/{code}"))
            until(lambda number=number: listens(names, f"/dump{number}"))
        until(lambda: sum(output.connections for output in outputs.values()) == len(KINDS))
        last = [
            tmp_path / f"dump{number}" / f"{FRAMES - 1:08d}{suffix}"
            for number, (*_, suffix, _) in enumerate(KINDS)
        ]
        count = itertools.count()

        def are_dumped():
            """It skips images that come faster than it takes them, so they come until there are enough."""
            number = next(count)
            for code, output in outputs.items():
                output.write(*image.encode(images[code], code), Stamp(number, 1234.5 + number).encode())
            return all(path.exists() for path in last)

        until(are_dumped)

    for number, (code, _, _, tolerance) in enumerate(KINDS):
        with closing(open_recording(tmp_path / f"dump{number}")) as recording:
            frames = [recording.frame(index, 0) for index in range(len(recording))]
            assert len(frames) >= FRAMES
            assert recording.times_ns == [1_234_500_000_000 + frame.frame_id * 10**9 for frame in frames]
        for frame in frames:
            played = frame.rgb() if code == "rgb" else frame.raw()
            assert np.allclose(played.astype(float), images[code], atol=tolerance)
