"""Replaces names, serial numbers and addresses in a report by stand-ins.

The same name gets the same stand-in wherever it occurs: in texts, in the description, and in the bytes of
registers, where a stand-in is as long as the name. Addresses of one network stay addresses of one network.
Names that the user gave to the camera, or that identify the camera or this computer, are known from the
report itself; IP addresses in log and findings are replaced whether they are known or not.
"""

from __future__ import annotations

import getpass
import ipaddress
import re
import socket
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from grabbergui.core.environment import home
from grabbergui.driver.twin.report_file import CameraReport, RecordedAccess

SHORTEST = 4
"Characters of a name that is replaced inside texts; a shorter one only where it stands alone."
_LONG = 6
"Characters from which a name is replaced inside words too."
_LEAST_NUMBER = 10_000_000
"Serial numbers from which they are replaced as numbers too, unless they are round."

_SERIALS = ("DeviceSerialNumber", "DeviceID")
_USER_NAMES = ("DeviceUserID",)
_IP_REGISTERS = ("CURRENT_IP", "CURRENT_GATEWAY", "PERSISTENT_IP", "PERSISTENT_GATEWAY",
                 "PRIMARY_APPLICATION_IP", "MCDA", "SCDA")  # fmt: skip

_IP = re.compile(r"(?<![\d.])(?:\d{1,3}\.){3}\d{1,3}(?![\d.]*\d)")
_MAC = re.compile(r"[0-9a-f]{2}(?::[0-9a-f]{2}){5}", re.IGNORECASE)
_XML_TEXT = re.compile(r"<(ToolTip|Description|DisplayName|DocuURL)>[^<]*<|<!--.*?-->", re.DOTALL)
"Texts of a description for humans; others are names of nodes, keywords and numbers."
_MIXED = re.compile(r"(?=.*\d)(?=.*[A-Za-z]).{6,}")
"Names that are replaced in a whole description, as no node and no number is written so."


def without_names(report: CameraReport) -> CameraReport:
    """Return the report with stand-ins."""
    found = _Names(report)
    stream, info, count = report.stream, report.info, len(report.bootstrap)
    registers = found.registers((*report.bootstrap, *report.registers))
    hidden = {
        name: found.value(getattr(info, name))
        for name in ("serial", "user_name", "hardware_id", "address", "interface", "note")
    }
    return replace(
        report,
        info=replace(info, uri=found.text(info.uri), **hidden),
        description=found.description(report.description),
        bootstrap=registers[:count],
        registers=registers[count:],
        stream=replace(
            stream,
            accesses=tuple(map(found.access, stream.accesses)),
            frames=tuple(replace(frame, chunks=found.value(frame.chunks)) for frame in stream.frames),
        ),
        features=tuple(map(found.feature, report.features)),
        problems=tuple(found.everywhere(text) for text in report.problems),
        computer=found.value(report.computer, everywhere=True),
        log=found.everywhere(report.log),
        made={**report.made, "names": "replaced by stand-ins"},
    )


class _Names:
    """The names in a report, and their stand-ins."""

    def __init__(self, report: CameraReport) -> None:
        self._texts: dict[str, str] = {}
        "Stand-ins for texts of the camera and its network."
        self._computer: dict[str, str] = {}
        "Stand-ins for texts of this computer, used only in texts about it."
        self._numbers: dict[int, int] = {}
        self._bytes: dict[bytes, bytes] = {}
        "Binary forms, all of one length for name and stand-in."
        self._addresses: dict[str, str] = {}
        self._networks: dict[str, int] = {}
        self._hosts: dict[str, int] = {}
        self._public = (report.info.vendor, report.info.model)
        self._find(report)
        self._pattern = _alternatives(self._texts)
        self._unusual = _alternatives(filter(_MIXED.fullmatch, self._texts))
        self._every = _alternatives({**self._texts, **self._computer})

    def value(self, content: Any, *, everywhere: bool = False) -> Any:
        """Return JSON content with the stand-ins; `everywhere`: also of this computer, and all addresses."""
        if isinstance(content, str):
            whole = self._texts.get(content) or self._texts.get(content.lower())
            return whole or (self.everywhere(content) if everywhere else self.text(content))
        if isinstance(content, bool):
            return content
        if isinstance(content, int):
            return self._numbers.get(content, content)
        if isinstance(content, Mapping):
            return {key: self.value(each, everywhere=everywhere) for key, each in content.items()}
        if isinstance(content, list | tuple):
            return [self.value(each, everywhere=everywhere) for each in content]
        return content

    def text(self, text: str) -> str:
        """Return a text with the stand-ins for the camera's names."""
        return self._pattern.sub(lambda match: self._stand_in(match[0]), text)

    def everywhere(self, text: str) -> str:
        """Return a text with the stand-ins for all names and all IP addresses."""
        text = self._every.sub(lambda match: self._stand_in(match[0]), text)
        return _IP.sub(lambda match: self._address(match[0]), text)

    def description(self, xml: bytes) -> bytes:
        """Return a description with the stand-ins in texts for humans; those of unusual names anywhere."""
        text = xml.decode("utf-8", "surrogateescape")  # keeps every byte
        text = self._unusual.sub(lambda match: self._stand_in(match[0]), text)
        return _XML_TEXT.sub(lambda match: self.text(match[0]), text).encode("utf-8", "surrogateescape")

    def feature(self, row: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a feature's row with the stand-ins; an enumeration's value is no name."""
        problem = self.text(str(row["problem"]))
        value = row["value"] if row["kind"] == "enumeration" else self.value(row["value"])
        return {**row, "value": value, "problem": problem}

    def access(self, access: RecordedAccess) -> RecordedAccess:
        """Return an access with the stand-ins in its bytes and its message."""
        data = None if access.data is None else self._binary(access.data)
        return replace(access, data=data, message=self.text(access.message))

    def registers(self, accesses: Iterable[RecordedAccess]) -> tuple[RecordedAccess, ...]:
        """Return accesses with the stand-ins, also of names that extend over several registers."""
        replaced = list(map(self.access, accesses))
        order = sorted(range(len(replaced)), key=lambda index: replaced[index].address)
        run: list[int] = []
        for index in (*order, -1):
            each = replaced[index] if index >= 0 else None
            if run and (each is None or each.data is None or each.address != replaced[run[-1]].end):
                self._replace_in_run(replaced, run)
                run = []
            if each is not None and each.data is not None:
                run.append(index)
        return tuple(replaced)

    def _replace_in_run(self, replaced: list[RecordedAccess], run: list[int]) -> None:
        whole = self._binary(b"".join(replaced[index].data or b"" for index in run))
        at = 0
        for index in run:
            length = replaced[index].length
            replaced[index] = replace(replaced[index], data=whole[at : at + length])
            at += length

    def _binary(self, data: bytes) -> bytes:
        content = data.rstrip(b"\0")
        for name, stand_in in self._texts.items():
            raw, other = name.encode(), stand_in.encode()
            if len(other) == len(raw) and (len(name) >= SHORTEST or content == raw):
                data = data.replace(raw, other)
        for pattern, replacement in self._bytes.items():
            at = data.find(pattern)
            while at >= 0:
                if len(pattern) != 4 or at % 4 == 0:  # of numbers and addresses
                    data = data[:at] + replacement + data[at + len(pattern) :]
                at = data.find(pattern, at + len(pattern))
        return data

    def _stand_in(self, found: str) -> str:
        for known in (self._texts, self._computer):
            if found in known:
                return known[found]
            if found.lower() in known:
                return known[found.lower()]
        return found

    def _find(self, report: CameraReport) -> None:
        info, features = report.info, {row["name"]: row.get("value") for row in report.features}
        answers = report.computer.get("discovery", [])
        for serial in (info.serial, *(features.get(name) for name in _SERIALS), *_column(answers, "serial")):
            self._add_name(serial, "S")
        for name in (info.user_name, *map(features.get, _USER_NAMES), *_column(answers, "user_name")):
            self._add_name(name, "N")
        macs = [info.hardware_id, *_column(answers, "mac"), *_macs_of_computer()]
        for mac in macs:
            if _MAC.fullmatch(mac):
                self._add_mac(mac.lower())
            else:
                self._add_name(mac, "G")
        addresses = [info.address, *_column(answers, "ip"), *_column(answers, "gateway")]
        addresses += _column(report.computer.get("interfaces", []), "ip")
        for address in (*addresses, *_addresses_in(report)):
            if _IP.fullmatch(address):
                self._add_address(address)
        host, user = socket.gethostname(), _user()
        for name, stand_in in ((host, "computer"), (str(home()), "~"), (user, "user")):
            if len(name) >= SHORTEST and name not in ("localhost", "root", "/root"):
                self._computer[name] = stand_in

    def _add_name(self, name: object, letter: str) -> None:
        if isinstance(name, int) and not isinstance(name, bool) and name >= _LEAST_NUMBER:
            name = str(name)
        if not isinstance(name, str) or not name.strip() or name in (*self._texts, *self._public):
            return
        number = len(self._texts) + 1
        size = len(name.encode())
        if name.isascii() and name.isdigit():
            self._texts[name] = str(number).zfill(size)[-size:]
            if int(name) >= _LEAST_NUMBER and int(name) % 1000:
                self._add_number(int(name), number)
        else:
            self._texts[name] = (letter + str(number).zfill(size - 1))[-size:] if size > 1 else letter

    def _add_number(self, number: int, stand_in: int) -> None:
        self._numbers[number] = stand_in
        for size in (4, 8):
            if number < 1 << 8 * size:
                for order in ("big", "little"):
                    self._bytes[number.to_bytes(size, order)] = stand_in.to_bytes(size, order)

    def _add_mac(self, mac: str) -> None:
        plain = mac.replace(":", "")
        if plain in self._texts or not int(plain, 16):
            return
        stand_in = f"{0x020000000000 + len(self._texts) + 1:012x}"
        colons = ":".join(stand_in[at : at + 2] for at in range(0, 12, 2))
        self._texts |= {plain: stand_in, mac: colons, mac.replace(":", "-"): colons.replace(":", "-")}
        self._numbers[int(plain, 16)] = int(stand_in, 16)
        raw, other = bytes.fromhex(plain), bytes.fromhex(stand_in)
        self._bytes |= {raw: other, raw[::-1]: other[::-1]}
        # As two registers of a little-endian device.
        self._bytes[raw[1::-1] + b"\0\0" + raw[:1:-1]] = other[1::-1] + b"\0\0" + other[:1:-1]

    def _add_address(self, address: str) -> None:
        stand_in = self._address(address)
        if stand_in == address or address in self._texts:
            return
        self._texts[address] = stand_in
        raw, other = socket.inet_aton(address), socket.inet_aton(stand_in)
        self._bytes |= {raw: other, raw[::-1]: other[::-1]}
        self._numbers[int.from_bytes(raw, "big")] = int.from_bytes(other, "big")

    def _address(self, address: str) -> str:
        """Return the stand-in of an IP address; masks, loopback and multicast stand for themselves."""
        if address in self._addresses:
            return self._addresses[address]
        try:
            ip = ipaddress.IPv4Address(address)
        except ValueError:
            return address  # such as a version
        if ip.is_loopback or ip.is_multicast or ip.is_reserved or int(ip) < 1 << 24:
            return address
        network, _, last = address.rpartition(".")
        index = self._networks.setdefault(network, len(self._networks))
        if last not in ("0", "255"):
            self._hosts[network] = self._hosts.get(network, 0) + 1
            last = str((self._hosts[network] - 1) % 254 + 1)
        stand_in = f"10.{index >> 8 & 0xFF}.{index & 0xFF}.{last}"
        self._addresses[address] = self._addresses[stand_in] = stand_in
        return self._addresses[address]


def _alternatives(names: Iterable[str]) -> re.Pattern[str]:
    """Return a pattern that finds names, the longest first; short ones only as whole words."""
    parts = []
    for name in sorted(names, key=len, reverse=True):
        if len(name) >= SHORTEST:
            part = re.escape(name)
            parts.append(part if len(name) >= _LONG else rf"(?<![0-9A-Za-z]){part}(?![0-9A-Za-z])")
    return re.compile("|".join(parts) or r"(?!)", re.IGNORECASE)


def _column(rows: Iterable[Mapping[str, Any]], name: str) -> list[str]:
    return [str(row.get(name, "")) for row in rows]


def _addresses_in(report: CameraReport) -> list[str]:
    """Return the IP addresses in GigE Vision's registers."""
    big = report.numbers or not report.little_endian
    return [
        socket.inet_ntoa(each.data if big else each.data[::-1])
        for each in report.bootstrap
        if each.data is not None and len(each.data) == 4 and each.name.rstrip("0123456789") in _IP_REGISTERS
    ]


def _macs_of_computer() -> list[str]:
    found = []
    for place in Path("/sys/class/net").glob("*/address"):
        with suppress(OSError):
            found.append(place.read_text().strip())
    return found


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):  # a user without a name, as in containers
        return ""
