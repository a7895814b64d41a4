"""Events and chunks of the simulated camera as the EMVA's own adapters read them."""

import struct

import numpy as np
import pytest
from genicam import genapi

from grabbergui.driver.gige.gvcp_messages import Event
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.chunks import append_chunks, chunk_bytes
from grabbergui.driver.sim.enumerations import Chunk, TransportLayer
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.model import CameraModel


class Port(genapi.AbstractPort):
    """The model's registers, without a transport."""

    def __init__(self, model):
        super().__init__()
        self.model = model

    def read(self, address, length):
        return self.model.read(address, length)

    def write(self, address, value):
        self.model.write(address, bytes(value))

    def get_access_mode(self):
        return genapi.EAccessMode.RW

    def is_open(self):
        return True

    def get_principal_interface_type(self):
        return genapi.EInterfaceType.intfIPort


@pytest.fixture
def node_map():
    port = Port(CameraModel(power_on={reg.DEVICE_TL_TYPE: int(TransportLayer.GIGE_VISION)}))
    nodes = genapi.NodeMap()
    nodes.load_xml_from_string(gev.description().decode())
    nodes.connect(port, "Device")
    yield nodes
    nodes.disconnect()


def test_event_data_becomes_features(node_map):
    adapter = genapi.EventAdapterGEV(node_map.pointer)
    data = struct.pack(">qq", 5, 123_456)
    adapter.deliver_message(Event(0x9003, 5, 77, data=data).encode(9))
    assert node_map.get_node("EventTestTimestamp").value == 123_456
    assert node_map.get_node("EventTestFrameID").value == 5
    adapter.detach_node_map()


def test_chunk_data_becomes_features(node_map):
    values = {
        Chunk.FRAME_ID: 3,
        Chunk.TIMESTAMP: 99,
        Chunk.EXPOSURE_TIME: 1234.5,
        Chunk.GAIN: 6.25,
    }
    payload = np.zeros(100 + chunk_bytes(tuple(values)), np.uint8)
    assert append_chunks(payload, 100, values) == len(payload)
    buffer = payload.tobytes()
    adapter = genapi.ChunkAdapterGEV(node_map)
    adapter.attach_buffer(buffer, len(buffer))
    names = ("ChunkFrameID", "ChunkTimestamp", "ChunkExposureTime", "ChunkGain")
    assert [node_map.get_node(name).value for name in names] == [3, 99, 1234.5, 6.25]
    adapter.detach_buffer()
    adapter.detach_node_map()
