"""Deviations of some GigE Vision cameras from the standard: one table, each row with its evidence.

Vendor and model are those of the description (`VendorName` and `ModelName` of RegisterDescription), or those
in the camera's registers, as patterns of `fnmatch`. Options override the rows, see `GigeUriOptions`.

**Byte order of registers.** READREG and WRITEREG carry numbers, most significant byte first; READMEM and
WRITEMEM carry the memory of the camera as it is, which is little-endian if bit 31 of DeviceMode is clear
(GenICam standard 2.1.1, appendix 3.1). A description of schema 1.1 or newer declares that order, register by
register. One of schema 1.0 declares BigEndian whatever the order is: its registers of four bytes are numbers,
which only READREG and WRITEREG carry alike for every camera. Some descriptions claim 1.1 and mean 1.0.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from fnmatch import fnmatchcase
from itertools import pairwise

# Tags contain no `<` outside of attributes, where XML forbids it, so none of these takes quadratic time.
_HEAD = re.compile(r"<(?:\w+:)?RegisterDescription\b([^<>]*)>")
_ATTRIBUTE = re.compile(r"""(\w+)\s*=\s*["']([^"'<>]*)["']""")
_NUMBER = re.compile(r"<(?:Masked)?IntReg\b|<FloatReg\b|<StructReg\b")
_PORT = re.compile(r"<pPort>\s*([^<\s]+)\s*<")


class Quirk(Enum):
    """A deviation from the standard."""

    NUMBERS = "registers of four bytes are numbers, as with schema 1.0, although the description claims 1.1"
    BIG_ENDIAN_PIXELS = "pixels of more than eight bits are big-endian, although SCPS does not say so"


@dataclass(frozen=True)
class KnownCamera:
    """One row: which cameras deviate, how, and who saw it."""

    quirk: Quirk
    vendor: str
    model: str
    evidence: str


_N, _P = Quirk.NUMBERS, Quirk.BIG_ENDIAN_PIXELS
KNOWN_CAMERAS = (
    KnownCamera(_P, "Point Grey Research", "Blackfly BFLY-PGE-*", "Aravis, issue 921: 31S4M, 14S2C"),
    KnownCamera(_P, "FLIR*", "A320G", "Aravis, issue 1029: A305sc"),
    KnownCamera(_N, "AT_Automation_Technology_GmbH", "C6_X_GigE", "Aravis, commit 91864addb"),
    KnownCamera(_N, "DO3THINK", "MGV518", "Aravis, pull request 1023"),
    KnownCamera(_N, "EVK", "HELIOS", "Aravis, pull request 817"),
    KnownCamera(_N, "FLIR", "XscSeries", "Aravis, issue 444: A6751; commit c69132656"),
    KnownCamera(_N, "IDS_Imaging_Development_Systems_GmbH", "GV_524xCP_NIR", "Aravis, commit 453a8a9a8"),
    KnownCamera(_N, "IDS_Imaging_Development_Systems_GmbH", "GV_53FxLE_M", "Aravis, pull request 1070"),
    KnownCamera(_N, "IDS_Imaging_Development_Systems_GmbH", "GV_58CxLE_M", "Aravis, pull request 1066"),
    KnownCamera(_N, "IDS_Imaging_Development_Systems_GmbH", "GV_599xCP_C", "Aravis, commit d36b7cc81"),
    KnownCamera(_N, "Imperx", "IpxGEVCamera", "Aravis, commit 839d279a6"),
    KnownCamera(_N, "KowaOptronics", "SC130ET3", "Aravis, commit 1b2cfd0a6"),
    KnownCamera(_N, "NIT", "NSC1601GIGE", "Aravis, commit 54c757938; of the NSC1104GIGE issue 203"),
    KnownCamera(_N, "NIT", "Tachyon16k", "Aravis, commit e6b08d770"),
    KnownCamera(_N, "PleoraTechnologiesInc", "NTxGigE", "Aravis, issue 715"),
    KnownCamera(_N, "PleoraTechnologiesInc", "iPORTCLGigE", "Aravis, issue 179"),
    KnownCamera(_N, "Sony", "XCG_CGSeries", "Aravis, issue 179: XCG-CG240"),
    KnownCamera(_N, "Sony", "XCG_CPSeries", "Aravis, issue 836: XCG-CP510"),
    KnownCamera(_N, "TeledyneDALSA", "ICE", "Aravis, issue 490"),
    KnownCamera(_N, "Xenics", "Wildcat", "Aravis, commit aa942d813"),
)


def known(quirk: Quirk, vendor: str, model: str) -> bool:
    """Return whether the table lists a camera with a quirk."""
    return any(
        row.quirk is quirk and fnmatchcase(vendor, row.vendor) and fnmatchcase(model, row.model)
        for row in KNOWN_CAMERAS
    )


@dataclass(frozen=True)
class DescriptionTraits:
    """The parts of a description that concern the transport."""

    vendor: str
    model: str
    schema: tuple[int, int]
    "Version of GenApi: major, minor."
    all_big_endian: bool
    "Whether every number in the camera's registers is declared big-endian."

    @classmethod
    def of(cls, xml: str, port: str = "Device") -> DescriptionTraits:
        """Read them from the text of a description; `port` leads to the camera's registers."""
        head = _HEAD.search(xml)
        attributes = dict(_ATTRIBUTE.findall(head[1])) if head else {}

        def number(name: str) -> int:
            return int(text) if (text := attributes.get(name, "")).isdecimal() else 1

        return cls(
            attributes.get("VendorName", ""),
            attributes.get("ModelName", ""),
            (number("SchemaMajorVersion"), number("SchemaMinorVersion")),
            all_big_endian=_all_big_endian(xml, port),
        )

    def has(self, quirk: Quirk) -> bool:
        """Return whether the table lists the camera with this quirk."""
        return known(quirk, self.vendor, self.model)

    def contradict(self, *, little_endian: bool) -> bool:
        """Return whether a description that should declare the camera's byte order declares another.

        Only READREG and WRITEREG are right then, whichever of the two is wrong. `little_endian`: whether the
        camera says so of its memory (DeviceMode).
        """
        declares = self.schema >= (1, 1) and not self.has(Quirk.NUMBERS)
        return declares and little_endian and self.all_big_endian

    def numbers(self, *, little_endian: bool) -> bool:
        """Return whether registers of four bytes must be read and written as numbers."""
        return self.schema < (1, 1) or self.has(Quirk.NUMBERS) or self.contradict(little_endian=little_endian)


def _all_big_endian(xml: str, port: str) -> bool:
    """Return whether all numbers of a port are declared big-endian; the default is little-endian."""
    starts = [match.start() for match in _NUMBER.finditer(xml)]
    found = False
    for start, end in pairwise([*starts, len(xml)]):
        close = xml.find("Reg>", start, end)  # of </IntReg>, </MaskedIntReg>, </FloatReg> or </StructReg>
        node = xml[start : close if close > 0 else end]
        leads = _PORT.search(node)
        if leads and leads[1] == port:
            found = True
            if not re.search(r"<Endianess>\s*BigEndian\s*<", node):
                return False
    return found
