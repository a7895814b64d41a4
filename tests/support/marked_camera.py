"""A simulated camera whose every text is marked, as a hostile one's would be."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import fields

from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim.camera_xml import camera_xml
from grabbergui.driver.sim.device import SimulatedDevice
from grabbergui.driver.sim.memory import Register, RegisterValue
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.registers import DEVICE_USER_ID, DEVICE_VENDOR_NAME

MARKUP = '<img src="/dev/null"><b>X</b>'
"""What Qt would take for rich text."""
CONTROL = "\u202eA\u200b\x9b31mB\r\n⁂"
"""What a terminal would obey or hide, as far as XML can hold it."""
MORE_CONTROL = f"{CONTROL}\x1b]0;t\x07\x08\x00"
"""The same with what registers can hold, too."""
LONG = 100_000
LONG_TEXTS = ("ExposureTime", "ExposureAuto", "Continuous", "AcquisitionControl")
"""Nodes whose texts have so many more characters."""
_TEXTS = ("ToolTip", "Description", "DisplayName")
_NODES = (
    "Category", "Integer", "IntReg", "MaskedIntReg", "Float", "FloatReg", "StringReg", "String", "Boolean",
    "Enumeration", "EnumEntry", "Command", "IntSwissKnife", "SwissKnife", "Converter", "IntConverter",
)  # fmt: skip


def marked_description(mark: str) -> bytes:
    """Return the simulated camera's description with the mark in every text of every node, and as unit."""
    root = ElementTree.fromstring(camera_xml())
    space = root.tag.partition("}")[0] + "}" if root.tag.startswith("{") else ""
    ElementTree.register_namespace("", space.strip("{}"))
    for node in root.iter():
        if node.tag.removeprefix(space) not in _NODES:
            continue
        for child in [child for child in node if child.tag.removeprefix(space) in _TEXTS]:
            node.remove(child)
        for place, name in enumerate(_TEXTS):
            text = ElementTree.Element(f"{space}{name}")
            text.text = f"{mark}{node.get('Name')}{'x' * LONG if node.get('Name') in LONG_TEXTS else ''}"
            node.insert(place, text)
        for child in node:
            if child.tag.removeprefix(space) == "Unit":
                child.text = mark
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)


class _Marked(SimulatedDevice):
    def __init__(self, info: DeviceInfo, model: CameraModel, mark: str) -> None:
        super().__init__(info, model)
        self._mark = mark

    def description(self) -> bytes:
        return marked_description(self._mark)


def marked_info(mark: str, uri: str = "sim:") -> DeviceInfo:
    """Return properties with the mark in all of them but the URI."""
    texts = {
        each.name: f"{mark}{each.name}" for each in fields(DeviceInfo) if each.name not in ("uri", "note")
    }
    return DeviceInfo(uri, **texts)


def marked_camera(uri: SourceUri, mark: str, name: str = "") -> DeviceGrabber:
    """Return the camera, not yet open; `name` is in its string registers."""
    power_on: dict[Register, RegisterValue] = dict.fromkeys(
        (DEVICE_USER_ID, DEVICE_VENDOR_NAME), name or mark
    )
    return DeviceGrabber(_Marked(marked_info(mark, str(uri)), CameraModel(power_on=power_on), mark))
