"""Frames in formats that only their camera's description names."""

from __future__ import annotations

import numpy as np
import pytest

from fakes import XmlDevice
from grabbergui.core import pfnc
from grabbergui.core.component import Component
from grabbergui.core.frame import Frame
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.recording.stored_frames import format_named, stored_name

CODES = {"Mono8": 0x01080001, "BayerRG12Packed": 0x810C0002, "Mono8HB": 0x81080001, "EVT3_0": 0x81080300}
XML = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="V" VendorName="V"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/><Category Name="Root"><pFeature>PixelFormat</pFeature>
<pFeature>AcquisitionStart</pFeature><pFeature>AcquisitionStop</pFeature></Category>
<Enumeration Name="PixelFormat">""" + "".join(
    f'<EnumEntry Name="{name}"><Value>{code}</Value></EnumEntry>' for name, code in CODES.items()
)
XML += f"""<Value>{CODES["Mono8"]}</Value></Enumeration>
<Integer Name="PayloadSize"><Value>96</Value></Integer>
<Command Name="AcquisitionStart"><Value>0</Value><CommandValue>1</CommandValue></Command>
<Command Name="AcquisitionStop"><Value>0</Value><CommandValue>1</CommandValue></Command>
</RegisterDescription>"""


class Sender(XmlDevice):
    """Delivers what the test gives it."""

    def open_stream(self, request, deliver):
        self.deliver = deliver

    def close_stream(self):
        pass


@pytest.fixture
def camera():
    camera = DeviceGrabber(Sender(XML.encode()))
    camera.open()
    yield camera
    camera.close()


def frame_of(code: int, **more) -> Frame:
    return Frame(np.arange(96, dtype=np.uint8), 8, 8, pfnc.by_code(code), **more)


def received(camera: DeviceGrabber, frame: Frame) -> Frame:
    queue = camera.open_queue()
    camera.start()
    try:
        camera.device.deliver(frame)
        return queue.get(5)
    finally:
        camera.stop()
        queue.close()


def test_a_code_that_the_camera_gives_a_known_name_is_decoded(camera):
    frame = received(camera, frame_of(0x810C0002))

    assert frame.pixel_format is pfnc.by_name("BayerRG12Packed")
    expected = Frame(np.arange(96, dtype=np.uint8), 8, 8, pfnc.by_name("BayerRG12Packed"))
    assert np.array_equal(frame.rgb(), expected.rgb())


@pytest.mark.parametrize("name", ["Mono8HB", "EVT3_0"])
def test_a_code_of_an_unknown_name_is_raw_data_of_that_name(camera, name):
    frame = received(camera, frame_of(CODES[name]))

    assert frame.pixel_format.name == name
    assert not frame.pixel_format.convertible
    assert format_named(stored_name(frame.pixel_format)) == frame.pixel_format


def test_the_parts_of_a_frame_are_named_too(camera):
    data = np.arange(96, dtype=np.uint8)
    parts = tuple(
        Component(data, 8, 8, pfnc.by_code(code)) for code in (CODES["Mono8"], CODES["BayerRG12Packed"])
    )
    frame = received(camera, frame_of(CODES["Mono8"], parts=parts))

    assert [part.pixel_format.name for part in frame.parts] == ["Mono8", "BayerRG12Packed"]
