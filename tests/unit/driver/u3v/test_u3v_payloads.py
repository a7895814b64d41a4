"""Payloads of USB3 Vision other than one image, from the simulated camera to the driver."""

from __future__ import annotations

import numpy as np
import pytest

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.errors import PixelFormatError
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim.contents import range_image
from grabbergui.driver.sim.settings import settings_of
from u3v_frames import grab


@pytest.mark.parametrize("chunks", [False, True], ids=["", "chunks"])
def test_the_components_of_a_gendc_container(plug_in, chunks) -> None:
    simulated, device = plug_in(width=72, height=50)
    camera = DeviceGrabber(device)
    camera.open()
    camera.write_feature("ComponentSelector", "Range")
    camera.write_feature("ComponentEnable", True)
    camera.write_feature("GenDCStreamingMode", "On")
    camera.write_feature("ChunkModeActive", chunks)
    frames = grab(camera, 3)
    settings = settings_of(simulated.model.memory)
    for frame in frames:
        assert frame.complete and frame.payload_type is PayloadType.GENDC
        intensity, distance = frame.components
        assert (intensity.kind, distance.kind) == (ComponentKind.INTENSITY, ComponentKind.RANGE)
        assert np.array_equal(distance.raw(), range_image(settings, frame.frame_id + 1))
        assert np.array_equal(frame.raw(), intensity.raw())
        # a ramp that moves: neighbours differ by one
        assert set(np.diff(frame.raw().astype(int) % 256, axis=1).reshape(-1).tolist()) <= {0, 1, -255}
        assert ("ChunkFrameID" in frame.chunks) is chunks
    camera.close()


def test_chunks_alone(plug_in) -> None:
    _, device = plug_in(width=72, height=50)
    camera = DeviceGrabber(device)
    camera.open()
    camera.write_feature("ChunkModeActive", True)
    camera.write_feature("PayloadType", "ChunkOnly")
    for frame in grab(camera, 3):
        assert frame.complete and frame.payload_type is PayloadType.CHUNK
        assert frame.chunks["ChunkFrameID"] == frame.frame_id + 1
        assert not frame.components
        with pytest.raises(PixelFormatError, match=r"no image: .*chunk data"):
            frame.raw()
    camera.close()
