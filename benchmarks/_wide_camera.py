"""The simulated camera with thousands of added nodes, as many as the largest real descriptions have."""

import re
import struct

from grabbergui.core.uri import SourceUri
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim.device import SimulatedDevice, create_device

BASE = 0x4000_0000
"Address of the first added register."
CATEGORIES = 56
LEVELS = ("Beginner", "Expert", "Guru")

_FEATURES = """
<Integer Name="{0}Count"><DisplayName>{1} Count</DisplayName><Visibility>{2}</Visibility>
  <pValue>{0}CountReg</pValue><Min>0</Min><Max>65535</Max><Inc>1</Inc></Integer>
<IntReg Name="{0}CountReg"><Address>{3}</Address><Length>4</Length><AccessMode>RW</AccessMode>
  <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
<Float Name="{0}Level"><DisplayName>{1} Level</DisplayName><Visibility>{2}</Visibility>
  <pValue>{0}LevelKnife</pValue><Min>0</Min><Max>1000</Max><Unit>us</Unit></Float>
<Converter Name="{0}LevelKnife"><pVariable Name="OTHER">{0}CountReg</pVariable>
  <FormulaTo>FROM*10</FormulaTo><FormulaFrom>TO/10.0</FormulaFrom><pValue>{0}LevelReg</pValue></Converter>
<IntReg Name="{0}LevelReg"><Address>{4}</Address><Length>4</Length><AccessMode>RW</AccessMode>
  <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
<Enumeration Name="{0}Mode"><DisplayName>{1} Mode</DisplayName><Visibility>{2}</Visibility>
  <EnumEntry Name="Off"><Value>0</Value></EnumEntry><EnumEntry Name="On"><Value>1</Value></EnumEntry>
  <pValue>{0}ModeReg</pValue></Enumeration>
<IntReg Name="{0}ModeReg"><Address>{5}</Address><Length>4</Length><AccessMode>RW</AccessMode>
  <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
"""
"""XML of one unit: three visible features; nine nodes with their registers and entries."""
UNITS = 7
"Number of units in each category."


def wide_description(xml: bytes) -> bytes:
    """Return a description with about three thousand more nodes, in categories of their own."""
    categories, features = [], []
    for category in range(CATEGORIES):
        names = [f"Unit{category}x{unit}" for unit in range(UNITS)]
        parts = [f"{name}{part}" for name in names for part in ("Count", "Level", "Mode")]
        members = "".join(f"<pFeature>{part}</pFeature>" for part in parts)
        categories.append(f'<Category Name="Wide{category}">{members}</Category>')
        for unit, name in enumerate(names):
            address = BASE + 16 * (category * UNITS + unit)
            level = LEVELS[unit % len(LEVELS)]
            features.append(
                _FEATURES.format(name, f"Unit {category} {unit}", level, address, address + 4, address + 8)
            )
    text = xml.decode()
    root = "".join(f"<pFeature>Wide{category}</pFeature>" for category in range(CATEGORIES))
    text = re.sub(r'(<Category Name="Root".*?)(</Category>)', rf"\1{root}\2", text, count=1, flags=re.S)
    end = text.rindex("</RegisterDescription>")
    return (text[:end] + "".join(categories + features) + text[end:]).encode()


def nodes(xml: bytes) -> int:
    return len(re.findall(rb'<[A-Z]\w+ Name="', xml))


class WideDevice(SimulatedDevice):
    """The simulated camera with the wide description; it streams as before."""

    def __init__(self, inner: SimulatedDevice) -> None:
        super().__init__(inner.info, inner.model)
        self.added: dict[int, bytes] = {}

    def description(self) -> bytes:
        return wide_description(super().description())

    def read(self, address: int, length: int) -> bytes:
        if address >= BASE:
            return self.added.get(address, struct.pack(">I", 1))
        return super().read(address, length)

    def write(self, address: int, data: bytes) -> None:
        if address >= BASE:
            self.added[address] = data
        else:
            super().write(address, data)


def create_wide(uri: SourceUri) -> DeviceGrabber:
    """Return a grabber of the wide camera, whatever the URI's scheme."""
    return DeviceGrabber(WideDevice(create_device(SourceUri("sim", uri.name, uri.options))))
