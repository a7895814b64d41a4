"""Makes the GenICam description of a video device from its controls and formats. No I/O.

Controls that exist in SFNC get its names and units (`exposure_time_absolute` in 100 µs becomes ExposureTime
in µs, its automatic mode ExposureAuto); others keep their own names in CamelCase. Registers have eight bytes,
little-endian; `REGISTERS` has the fixed ones, `WebcamDescription.controls` those of controls.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import NamedTuple

from grabbergui.driver.v4l2.video import Control, ControlKind, FrameSizes

TEXTS = {
    "DeviceVendorName": 0x100,
    "DeviceModelName": 0x140,
    "DeviceSerialNumber": 0x180,
    "DeviceVersion": 0x1C0,
    "DeviceID": 0x200,
}
TEXT_BYTES = 64
REGISTERS = {
    "PixelFormat": 0x1000,
    "Width": 0x1008,
    "Height": 0x1010,
    "Resolution": 0x1018,
    "PayloadSize": 0x1020,
    "AcquisitionFrameRate": 0x1028,
    "FrameRateMin": 0x1030,
    "FrameRateMax": 0x1038,
    "TLParamsLocked": 0x1040,
    "AcquisitionStart": 0x1048,
    "AcquisitionStop": 0x1050,
    "AcquisitionMode": 0x1058,
}
FIRST_CONTROL = 0x4000
CONTROL_BYTES = 16
"A control's value and its lock, eight bytes each."

PFNC_NAMES = {
    "GREY": "Mono8",
    "Y10 ": "Mono10",
    "Y12 ": "Mono12",
    "Y16 ": "Mono16",
    "RGB3": "RGB8",
    "BGR3": "BGR8",
    "YUYV": "YUV422_8",
    "UYVY": "YUV422_8_UYVY",
    "BA81": "BayerBG8",
    "GBRG": "BayerGB8",
    "GRBG": "BayerGR8",
    "RGGB": "BayerRG8",
    "MJPG": "MJPG",
    "JPEG": "JPEG",
}
"""Supported pixel formats by V4L2's code. JPEG frames are delivered as BGR8."""
COMPRESSED = ("MJPG", "JPEG")
_OFF_ON = {0: "Off", 1: "Continuous"}
_EXPOSURE_MODES = {1: "Off", 3: "Continuous", 0: "Automatic", 2: "ShutterPriority"}
"In order of preference: webcams' normal automatic exposure is called aperture priority."
CATEGORIES = (
    "DeviceControl",
    "ImageFormatControl",
    "AcquisitionControl",
    "AnalogControl",
    "LensControl",
    "VideoControl",
    "TransportLayerControl",
)
_SCHEMA = " ".join(
    (
        'StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"',
        'MajorVersion="1" MinorVersion="0" SubMinorVersion="0"',
        'ProductGuid="7B1D0E52-6A53-4F0B-9C0B-2A1C6E5B9D10"',
        'VersionGuid="0C5A7F0E-5B0D-4D7B-8B69-6E8B7D5C4A21"',
        'xmlns="http://www.genicam.org/GenApi/Version_1_1"',
    )
)
_KEPT = ("Integer", "Float", "Enumeration", "Boolean", "Converter")
_STREAM_LOCKS = "<pIsLocked>TLParamsLocked</pIsLocked>"
_RO, _RW = "<AccessMode>RO</AccessMode>", "<AccessMode>RW</AccessMode>"
_PORT = "<pPort>Device</pPort>"
_FRESH = "<Cachable>NoCache</Cachable><PollingTime>500</PollingTime>"
_LITTLE = "<Endianess>LittleEndian</Endianess>"


class Standard(NamedTuple):
    """The SFNC feature for a control."""

    name: str
    category: str = "AnalogControl"
    unit: str = ""
    factor: int = 1
    "Units of the feature in one step of the control."
    entries: dict[int, str] | None = None
    "Entries of an automatic mode: names by the control's value."


STANDARD = {
    0x009A0901: Standard("ExposureAuto", "AcquisitionControl", entries=_EXPOSURE_MODES),
    0x009A0902: Standard("ExposureTime", "AcquisitionControl", "us", 100),
    0x00980911: Standard("Exposure", "AcquisitionControl"),
    0x00980913: Standard("Gain"),
    0x00980912: Standard("GainAuto", entries=_OFF_ON),
    0x0098090C: Standard("BalanceWhiteAuto", entries=_OFF_ON),
    0x0098091A: Standard("BalanceTemperature", unit="K"),
    0x00980900: Standard("Brightness"),
    0x00980901: Standard("Contrast"),
    0x00980902: Standard("Saturation"),
    0x00980903: Standard("Hue"),
    0x00980910: Standard("Gamma"),
    0x0098091B: Standard("Sharpness"),
    0x00980914: Standard("ReverseX", "ImageFormatControl"),
    0x00980915: Standard("ReverseY", "ImageFormatControl"),
    0x009A090A: Standard("Focus", "LensControl"),
    0x009A090C: Standard("FocusAuto", "LensControl", entries=_OFF_ON),
    0x009A090D: Standard("Zoom", "LensControl"),
    0x009A0908: Standard("Pan", "LensControl"),
    0x009A0909: Standard("Tilt", "LensControl"),
    0x009A0911: Standard("Iris", "LensControl"),
}
"""SFNC features by V4L2_CID. The unit of gain is the driver's own."""


@dataclass(frozen=True)
class WebcamDescription:
    """A device's description, and the registers of its controls."""

    xml: bytes
    controls: dict[int, Control] = field(default_factory=dict)
    "By the address of the value; the lock is eight bytes further."


def describe(
    model: str, fourccs: Sequence[str], sizes: FrameSizes, controls: Sequence[Control]
) -> WebcamDescription:
    """Make the description; `sizes` are those of the current pixel format."""
    writer = _DescriptionWriter()
    writer.device()
    writer.image_format([code for code in fourccs if code in PFNC_NAMES], sizes)
    writer.acquisition()
    placed = {FIRST_CONTROL + CONTROL_BYTES * index: control for index, control in enumerate(controls)}
    for address, control in placed.items():
        writer.control(address, control)
    return WebcamDescription(writer.document(model), placed)


def resolution_value(width: int, height: int) -> int:
    """Return the Resolution register's value for a size."""
    return width << 32 | height


class _DescriptionWriter:
    """Collects nodes and the categories that list them."""

    def __init__(self) -> None:
        self._nodes: list[str] = []
        self._listed: dict[str, list[str]] = {category: [] for category in CATEGORIES}
        self._names: set[str] = set()

    def document(self, model: str) -> bytes:
        filled = {category: names for category, names in self._listed.items() if names}
        root = _element("Category", "Root", *(f"<pFeature>{name}</pFeature>" for name in filled))
        categories = [
            _element("Category", name, *(f"<pFeature>{feature}</pFeature>" for feature in features))
            for name, features in filled.items()
        ]
        name = _identifier(model, set())
        head = f'<RegisterDescription ModelName="{name}" VendorName="V4L2" {_SCHEMA}>'
        body = "\n".join([root, *categories, *self._nodes, '<Port Name="Device"/>'])
        return f'<?xml version="1.0" encoding="utf-8"?>\n{head}\n{body}\n</RegisterDescription>'.encode()

    def device(self) -> None:
        for name, address in TEXTS.items():
            place = (f"<Address>{address:#x}</Address>", f"<Length>{TEXT_BYTES}</Length>")
            self._add("DeviceControl", name, "StringReg", *place, _RO, _PORT)

    def image_format(self, fourccs: Sequence[str], sizes: FrameSizes) -> None:
        category = "ImageFormatControl"
        entries = [(PFNC_NAMES[code], code_value(code), "") for code in fourccs]
        self._enumeration(category, "PixelFormat", entries, _STREAM_LOCKS)
        if sizes.discrete:
            names = [(f"R{w}x{h}", resolution_value(w, h), f"{w} x {h}") for w, h in sizes.discrete]
            self._enumeration(category, "Resolution", names, _STREAM_LOCKS)
        for name, limits in (("Width", sizes.widths), ("Height", sizes.heights)):
            self._register(name, REGISTERS[name], writable=not sizes.discrete)
            low, high, step = limits
            bounds = (f"<Min>{low}</Min>", f"<Max>{high}</Max>", f"<Inc>{step}</Inc>") if high else ()
            unit = "<Unit>px</Unit>"
            self._add(category, name, "Integer", _STREAM_LOCKS, f"<pValue>{name}Reg</pValue>", *bounds, unit)

    def acquisition(self) -> None:
        category = "AcquisitionControl"
        self._enumeration(category, "AcquisitionMode", [("Continuous", 0, "")], "")
        for name in ("AcquisitionStart", "AcquisitionStop"):
            self._register(name, REGISTERS[name])
            self._add(
                category, name, "Command", f"<pValue>{name}Reg</pValue>", "<CommandValue>1</CommandValue>"
            )
        for name in ("AcquisitionFrameRate", "FrameRateMin", "FrameRateMax"):
            place = (f"<Address>{REGISTERS[name]:#x}</Address>", "<Length>8</Length>")
            access = _RW if name == "AcquisitionFrameRate" else _RO
            parts = (*place, access, _PORT, _FRESH, _LITTLE)
            self._nodes.append(_element("FloatReg", f"{name}Reg", *parts))
        self._add(
            category,
            "AcquisitionFrameRate",
            "Float",
            _STREAM_LOCKS,
            "<pValue>AcquisitionFrameRateReg</pValue>",
            "<pMin>FrameRateMinReg</pMin><pMax>FrameRateMaxReg</pMax><Unit>Hz</Unit>",
        )
        for name in ("PayloadSize", "TLParamsLocked"):
            self._register(name, REGISTERS[name], writable=name == "TLParamsLocked")
            visibility = "<Visibility>Expert</Visibility>"
            self._add("TransportLayerControl", name, "Integer", visibility, f"<pValue>{name}Reg</pValue>")

    def control(self, address: int, control: Control) -> None:
        standard = STANDARD.get(control.id)
        name = _identifier(standard.name if standard else control.name, self._names)
        category = standard.category if standard else "VideoControl"
        title = "" if standard else _display_name(control.name)
        lock = f"<pIsLocked>{name}LockReg</pIsLocked>"
        self._register(name, address)
        self._register(f"{name}Lock", address + 8, writable=False)
        value = f"<pValue>{name}Reg</pValue>"
        if control.kind is ControlKind.BUTTON:
            self._add(category, name, "Command", title + lock, value, "<CommandValue>1</CommandValue>")
        elif standard and standard.entries:
            entries = [
                (entry, value, "") for value, entry in _mode_entries(control, standard.entries).items()
            ]
            self._enumeration(category, name, entries, lock, made=True)
        elif control.kind is ControlKind.MENU:
            taken: set[str] = set()
            entries = [(_identifier(text, taken), number, text) for number, text in control.menu.items()]
            self._enumeration(category, name, entries, title + lock, made=True)
        elif control.kind is ControlKind.BOOLEAN:
            values = "<OnValue>1</OnValue><OffValue>0</OffValue>"
            self._add(category, name, "Boolean", title + lock, value, values)
        else:
            self._number(category, name, control, standard, title + lock)

    def _number(
        self, category: str, name: str, control: Control, standard: Standard | None, head: str
    ) -> None:
        bounds = f"<Min>{control.minimum}</Min><Max>{control.maximum}</Max><Inc>{control.step}</Inc>"
        unit = f"<Unit>{standard.unit}</Unit>" if standard and standard.unit else ""
        if standard is None or standard.factor == 1:
            self._add(category, name, "Integer", head, f"<pValue>{name}Reg</pValue>", bounds, unit)
            return
        self._nodes.append(_element("Integer", f"{name}Steps", f"<pValue>{name}Reg</pValue>", bounds))
        formulas = (
            f"<FormulaTo>FROM / {standard.factor}</FormulaTo>",
            f"<FormulaFrom>TO * {standard.factor}</FormulaFrom>",
            f"<pValue>{name}Steps</pValue>",
            unit,
            "<Representation>Logarithmic</Representation><Slope>Increasing</Slope>",
        )
        self._add(category, name, "Converter", head, *formulas)

    def _enumeration(
        self,
        category: str,
        name: str,
        entries: Sequence[tuple[str, int, str]],
        head: str,
        *,
        made: bool = False,
    ) -> None:
        if not entries:
            return  # the schema requires an entry
        if not made:
            self._register(name, REGISTERS[name])
        parts = [
            f'<EnumEntry Name="{entry}">{_display_name(title)}<Value>{value}</Value></EnumEntry>'
            for entry, value, title in entries
        ]
        self._add(category, name, "Enumeration", head, *parts, f"<pValue>{name}Reg</pValue>")

    def _register(self, name: str, address: int, *, writable: bool = True) -> None:
        place = (f"<Address>{address:#x}</Address>", "<Length>8</Length>")
        access = _RW if writable else _RO
        self._nodes.append(
            _element("IntReg", f"{name}Reg", *place, access, _PORT, _FRESH, "<Sign>Signed</Sign>", _LITTLE)
        )

    def _add(self, category: str, name: str, kind: str, *parts: str) -> None:
        self._names.add(name)
        self._listed[category].append(name)
        streamable = "<Streamable>Yes</Streamable>" if kind in _KEPT and name != "TLParamsLocked" else ""
        head, *rest = parts
        # The schema's order: description, lock, streamable, then the elements of the kind.
        self._nodes.append(_element(kind, name, head, streamable, *rest))


def _element(kind: str, name: str, *parts: str) -> str:
    return f'<{kind} Name="{name}">{"".join(parts)}</{kind}>'


def _mode_entries(control: Control, entries: dict[int, str]) -> dict[int, str]:
    """Return the entries of an automatic mode that the driver offers, by value.

    A single automatic entry is called Continuous, the entry that switches a mode on.
    """
    offered = control.menu if control.kind is ControlKind.MENU else (0, 1)
    names = {value: entry for value, entry in entries.items() if value in offered}
    automatic = [value for value, entry in names.items() if entry != "Off"]
    return names | ({automatic[0]: "Continuous"} if len(automatic) == 1 else {})


def code_value(fourcc: str) -> int:
    """Return the PixelFormat register's value for a four-character code."""
    return int.from_bytes(fourcc.encode("ascii"), "little")


def _display_name(text: str) -> str:
    """Return the element with a driver's text; empty if nothing of it is printable.

    XML does not allow control characters, nor the schema an empty name.
    """
    printable = "".join(letter if letter.isprintable() else " " for letter in text).strip()
    return f"<DisplayName>{escape(printable, quote=False)}</DisplayName>" if printable else ""


def _identifier(text: str, taken: set[str]) -> str:
    """Return a unique node name from a driver's text: `Power Line Frequency` gives PowerLineFrequency."""
    words = re.findall(r"[A-Za-z0-9]+", text)
    name = "".join(word[:1].upper() + word[1:] for word in words) or "Unnamed"
    name = f"N{name}" if name[0].isdigit() else name  # GenICam requires a letter
    unique, number = name, 2
    while unique in taken:
        unique, number = f"{name}{number}", number + 1
    taken.add(unique)
    return unique
