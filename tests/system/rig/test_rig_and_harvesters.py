"""harvesters opens each camera of a rig alone, through a camera maker's GenTL producer."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from grabbergui.rig import rig_file
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from makers_producer import needs_producer, producer
from namespaces import CAMERA, Network, network, run

__all__ = ["network"]

SECOND = "10.77.0.3"
FRAMES = 10
SETTINGS = ("TriggerMode", "ExposureTime", "Gain")
PROGRAM_TEXT = f"""
import json, os, sys
from harvesters.core import Harvester

harvester = Harvester()
harvester.add_file(sys.argv[1])
harvester.update()
found = {{}}
for index, device in enumerate(harvester.device_info_list):
    camera = harvester.create(index)
    nodes = camera.remote_device.node_map
    settings = {{name: getattr(nodes, name).value for name in {SETTINGS!r}}}
    camera.start()
    frames = []
    while len(frames) < {FRAMES}:
        fetched = camera.try_fetch(timeout=30)
        for buffer in fetched if isinstance(fetched, list) else [fetched]:  # one from each stream channel
            part = buffer.payload.components[0]
            frames.append([part.width, part.height, float(part.data.std())])
            buffer.queue()
    found[device.serial_number] = [settings, frames]
print(json.dumps(found), flush=True)
os._exit(0)  # harvesters 1.4.3 fails where it revokes the producer's buffers
"""


@needs_producer
@pytest.mark.skipif(importlib.util.find_spec("harvesters") is None, reason="harvesters is not installed")
def test_each_camera_is_opened_alone(network: Network, tmp_path: Path) -> None:
    network.join()
    run("ip", "-n", network.camera, "addr", "add", f"{SECOND}/24", "dev", "eth0")
    for address in (CAMERA, SECOND):
        network.start_camera("sim:?width=320&height=240&fps=25&exposure=2000", address)
    file = tmp_path / "stereo.yaml"
    entries = {
        name: CameraEntry(f"gige:{address}", {"ExposureTime": 3000, "Gain": 2})
        for name, address in (("left", CAMERA), ("right", SECOND))
    }
    rig_file.write(file, RigEntry(entries, trigger=TriggerEntry("action", 10)))
    in_host = ("ip", "netns", "exec", network.host, sys.executable)
    checked = run(*in_host, "-m", "grabbergui", "rig", "check", str(file), "-t", "1", "--json")
    assert '"complete"' in checked.stdout, checked.stderr

    done = run(*in_host, "-c", PROGRAM_TEXT, str(producer()))
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert len(found) == 2
    for settings, frames in found.values():
        assert settings == {"TriggerMode": "Off", "ExposureTime": 2000.0, "Gain": 0.0}
        assert len(frames) >= FRAMES
        assert all((width, height) == (320, 240) and contrast > 1 for width, height, contrast in frames)
