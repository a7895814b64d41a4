"""Cameras that differ from the standard and work nevertheless."""

from __future__ import annotations

import pytest

from fakes import XmlDevice
from grabbergui.driver.device_grabber import DeviceGrabber
from patience import attempts

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="V" VendorName="V"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>"""


def register(name: str, address: int) -> str:
    return (
        f'<IntReg Name="{name}"><Address>{address}</Address><Length>4</Length><AccessMode>RW</AccessMode>'
        "<pPort>Device</pPort><Cachable>NoCache</Cachable><Sign>Unsigned</Sign>"
        "<Endianess>BigEndian</Endianess></IntReg>"
    )


def integer(name: str, address: int, inside: str = "") -> str:
    return f'<Integer Name="{name}">{inside}<pValue>{name}R</pValue></Integer>{register(name + "R", address)}'


def enumeration(name: str, address: int, *entries: str) -> str:
    listed = "".join(
        f'<EnumEntry Name="{entry}"><Value>{value}</Value></EnumEntry>' for value, entry in enumerate(entries)
    )
    return f'<Enumeration Name="{name}">{listed}<pValue>{name}R</pValue></Enumeration>' + register(
        f"{name}R", address
    )


def command(name: str, address: int) -> str:
    """A command whose register can be read, and keeps its value."""
    return (
        f'<Command Name="{name}"><pValue>{name}R</pValue><CommandValue>1</CommandValue></Command>'
        + register(f"{name}R", address)
    )


class OddDevice(XmlDevice):
    """A register memory that accepts a stream, which stays empty."""

    def open_stream(self, request, deliver):
        pass

    def close_stream(self):
        pass


@pytest.fixture
def opened():
    cameras = []

    def open_camera(nodes: str, *features: str) -> DeviceGrabber:
        listed = "".join(f"<pFeature>{name}</pFeature>" for name in features)
        xml = f'{HEAD}<Category Name="Root">{listed}</Category>{nodes}</RegisterDescription>'
        cameras.append(DeviceGrabber(OddDevice(xml.encode())))
        cameras[-1].open()
        return cameras[-1]

    yield open_camera
    for camera in cameras:
        camera.close()


def test_a_start_command_whose_register_keeps_its_value_starts(opened):
    commands = command("AcquisitionStart", 0x10) + command("AcquisitionStop", 0x14)
    payload = '<Integer Name="PayloadSize"><Value>64</Value></Integer>'
    camera = opened(commands + payload, "AcquisitionStart", "AcquisitionStop", "PayloadSize")

    camera.start()
    assert camera.streaming
    camera.stop()
    for watch in attempts(0.5):  # once is enough to learn it
        with watch:
            camera.start()
            camera.stop()


def test_the_exposure_mode_is_timed_before_the_exposure_time_is_written(opened):
    exposure = integer("ExposureTimeRaw", 0x10)
    mode = enumeration("ExposureMode", 0x20, "Off", "Timed", "TriggerWidth")
    camera = opened(exposure + mode, "ExposureTimeRaw", "ExposureMode")
    assert camera.feature("ExposureMode").value == "Off"

    result = camera.write_setting(camera.setting("ExposureTimeRaw"), 5000)

    assert camera.feature("ExposureMode").value == "Timed"
    assert camera.feature("ExposureTimeRaw").value == 5000
    assert [str(change.key) for change in result.written] == ["ExposureMode", "ExposureTimeRaw"]


def test_an_exposure_time_that_the_exposure_mode_locks_can_be_written(opened):
    locked = "<pIsAvailable>IsTimed</pIsAvailable>"
    rule = (
        '<IntSwissKnife Name="IsTimed"><pVariable Name="MODE">ExposureMode</pVariable>'
        "<Formula>MODE = 1</Formula></IntSwissKnife>"
    )
    mode = enumeration("ExposureMode", 0x20, "Off", "Timed")
    camera = opened(integer("ExposureTime", 0x10, locked) + mode + rule, "ExposureTime", "ExposureMode")

    assert camera.write_feature("ExposureTime", 700).value == 700
