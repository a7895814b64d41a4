"""Limits against what cameras, files and peers claim: the last value that is accepted, and the first refused.

A limit without a test is no limit. The values are here, too, so that a change of one is a decision.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui.core import encoded_image, scheduling
from grabbergui.core.errors import (
    AccessDeniedError,
    LocalProtocolError,
    RemoteProtocolError,
    TransportError,
    UsageError,
)
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.settings import SettingKey
from grabbergui.driver import device
from grabbergui.driver.genapi import cleaning, vetting
from grabbergui.driver.genapi.cleaning import clean_xml
from grabbergui.driver.gige import gvcp
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.u3v import stream_protocol
from grabbergui.driver.u3v.stream_protocol import StreamRequirements, TransferPlan
from grabbergui.models import change_tracking
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.net import remote_grabber, tree
from grabbergui.net.tree import TreeService, read_category
from grabbergui.net.yarp import grabber_values, mjpeg
from grabbergui.net.yarp.os import admin, binary, carrier, codecs, framing, name_server, registry, values
from grabbergui.net.yarp.os.binary import decode_name_size
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect, Vocab

VALUES = {
    (cleaning, "MAX_XML_BYTES"): 64 << 20,
    (vetting, "MOST_NODES"): 30_000,
    (vetting, "MOST_REFERENCES"): 200_000,
    (vetting, "MOST_ENTRIES"): 4096,
    (vetting, "DEEPEST_XML"): 32,
    (vetting, "MOST_BRANCHES"): 1000,
    (vetting, "MOST_EVALUATIONS"): 100_000,
    (device, "MAX_PAYLOAD_BYTES"): 1 << 30,
    (encoded_image, "LARGEST_SIDE"): 1 << 16,
    (encoded_image, "MOST_PIXELS"): 1 << 28,
    (stream_protocol, "LARGEST_PAYLOAD"): 1 << 29,
    (stream_protocol, "LARGEST_LEADER"): 1 << 20,
    (gvcp, "MAX_MEMORY"): 536,
    (gvcp, "MAX_READS"): 135,
    (gvcp, "MAX_WRITES"): 67,
    (change_tracking, "MOST_KNOWN"): 20_000,
    (remote_grabber, "MOST_SEEN"): 500,
    (tree, "MEMORY"): 256,
    (tree, "_MAX_DEPTH"): 32,
    (tree, "_REVISION_DIGITS"): 20,
    (grabber_values, "MAX_VERTICES"): 1024,
    (mjpeg, "_JPEG_LIMIT"): 64 << 20,
    (admin, "_MANY_PROPERTIES"): 256,
    (admin, "_PROPERTY_BYTES"): 4096,
    (carrier, "NAME_LIMIT"): 1000,
    (binary, "MESSAGE_LIMIT"): 1 << 28,
    (codecs, "TEXT_REPLY_LIMIT"): 16 << 20,
    (registry, "PORT_LIMIT"): 200,
    (registry, "ADDRESS_LIMIT"): 64,
    (name_server, "ASKER_LIMIT"): 4000,
    (values, "MAX_ITEMS"): 10_000,
    (framing, "LINE_LIMIT"): 1 << 16,
    (scheduling, "MOST_WORK"): 0.25,
}


@every_case(("module", "name"), VALUES, ids=lambda part: getattr(part, "__name__", part))
def test_the_values(module: Any, name: str) -> None:
    assert getattr(module, name) == VALUES[module, name]


XML = b'<RegisterDescription ModelName="M"><Port Name="Device"/></RegisterDescription>'


def description_of_length(count: int) -> None:
    clean_xml(XML + b" " * (count - len(XML)))


def references(count: int) -> None:
    pairs, single = divmod(count, 2)
    nodes = "".join(
        f'<Integer Name="N{i}"><pMin>A</pMin><pMax>A</pMax><Value>1</Value></Integer>' for i in range(pairs)
    )
    nodes += '<Integer Name="L"><pMin>A</pMin><Value>1</Value></Integer>' * single
    vetting.vetted(
        f'<RegisterDescription ModelName="M"><Integer Name="A"><Value>1</Value></Integer>{nodes}'
        '<Port Name="Device"/></RegisterDescription>'
    )


def transfers(payload: int, leader: int = 64, trailer: int = 64) -> None:
    needs = StreamRequirements(4, False, payload, leader, trailer)
    TransferPlan.for_device(needs, 1 << 20)


def nested_categories(count: int) -> None:
    data: dict[str, Any] = {"name": "C"}
    for _ in range(count):
        data = {"name": "C", "members": [data]}
    read_category(data)


def vertices(count: int) -> None:
    grabber_values.read_values((grabber_values.ValueKind.VERTICES,), [[1, 2] * count], Dialect.YARP3)


class OnePort:
    """A port whose properties are set."""

    name = "/port"

    def __init__(self) -> None:
        self.properties: dict[str, Any] = {}
        self.commands = admin.PortCommands(self, images=False)  # type: ignore[arg-type]

    def set(self, key: str, value: Any) -> None:
        answer = self.commands.administer([Vocab("prop"), Vocab("set"), key, value])
        if answer[0] != Vocab("ok"):
            raise RemoteProtocolError(str(answer[1]))


def properties(count: int) -> None:
    port = OnePort()
    for number in range(count):
        port.set(f"p{number}", 1)
    assert len(port.properties) == count
    port.set("p0", 2)  # one that exists may always be changed


def property_of_size(count: int) -> None:
    port, key = OnePort(), "key"
    empty = len(key) + len(Bottle([""]).encode())
    port.set(key, "x" * (count - empty))


def size_of_name(count: int) -> None:
    decode_name_size(count.to_bytes(4, "little"))


def revision_of_digits(count: int) -> None:
    service = TreeService(ScriptedGrabber([]))
    try:
        service.perform("changes", "1" * count)
    finally:
        service.close()


@pytest.mark.parametrize(
    ("use", "limit", "message"),
    [
        (description_of_length, (cleaning, "MAX_XML_BYTES", 500), "501 bytes, at most 500"),
        (references, (vetting, "MOST_REFERENCES", 11), "more than 11 references"),
        (device.check_payload_size, (device, "MAX_PAYLOAD_BYTES", 0), "check PayloadSize"),
        (transfers, (stream_protocol, "LARGEST_PAYLOAD", 0), "make sense"),
        (lambda n: transfers(100, leader=n), (stream_protocol, "LARGEST_LEADER", 0), "make sense"),
        (lambda n: transfers(100, trailer=n), (stream_protocol, "LARGEST_LEADER", 0), "make sense"),
        (nested_categories, (tree, "_MAX_DEPTH", 0), "deeper than 32"),
        (revision_of_digits, (tree, "_REVISION_DIGITS", 0), "no whole number"),
        (vertices, (grabber_values, "MAX_VERTICES", 0), "more than 1024 vertices"),
        (properties, (admin, "_MANY_PROPERTIES", 0), "a port keeps 256 properties"),
        (property_of_size, (admin, "_PROPERTY_BYTES", 0), "at most 4096 bytes"),
        (
            lambda n: decode_name_size(n.to_bytes(4, "little")),
            (carrier, "NAME_LIMIT", 0),
            "1 to 1000",
        ),
        (lambda n: gvcp.ReadReg(tuple(range(0, 4 * n, 4))).payload(), (gvcp, "MAX_READS", 0), "135 fit"),
        (lambda n: gvcp.WriteReg(((4, 1),) * n).payload(), (gvcp, "MAX_WRITES", 0), "67 fit"),
    ],
    ids=lambda value: value[1].strip("_") if isinstance(value, tuple) else "",
)
def test_the_last_value_is_accepted_and_the_next_is_refused(
    use: Callable[[int], object], limit: tuple[Any, str, int], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, name, smaller = limit
    if smaller:
        monkeypatch.setattr(module, name, smaller)
    most = getattr(module, name)
    use(most)
    with pytest.raises((RemoteProtocolError, LocalProtocolError, UsageError, TransportError), match=message):
        use(most + 1)


@every_case("length", [0, 4, 8])
@every_case("address", [-1, -4, -8, -(1 << 32), (1 << 32) - 4, (1 << 32) - 8])
def test_no_command_goes_to_an_address_outside_the_cameras_32_bits(address: int, length: int) -> None:
    """A description can have an address computed that is negative."""

    class Link:
        def read_memory(self, at: int, count: int) -> bytes:
            assert 0 <= at <= at + count <= 1 << 32
            return bytes(count)

        def execute(self, request: Any) -> bytes:
            first = request.address if hasattr(request, "address") else request.writes[0][0]
            assert 0 <= first < 1 << 32
            return bytes(4)

        def read_register(self, register: int) -> int:
            return 0

    memory = DeviceMemory(Link())  # type: ignore[arg-type]
    memory.writable = True
    inside = address >= 0 and address + length <= 1 << 32
    for access in (lambda: memory.read(address, length), lambda: memory.write(address, bytes(length))):
        if inside:
            access()
        else:
            with pytest.raises(TransportError, match="outside the camera's 32-bit address space"):
                access()
    if not inside:
        return
    assert len(memory.read(address, length)) == length
    with pytest.raises(TransportError, match="-4 bytes at"):
        memory.read(0, -4)


@pytest.mark.parametrize(
    "write",
    [
        lambda memory: memory.write(0x20000, bytes(4)),
        lambda memory: memory.write_numbers(0x20000, bytes(4)),
        lambda memory: memory.write(0x20001, bytes(9)),
    ],
)
def test_nothing_is_sent_to_a_camera_that_is_open_for_reading_only(write: Callable[[Any], object]) -> None:
    class Link:
        def __getattr__(self, name: str) -> Any:
            raise AssertionError(f"{name} was called")

    with pytest.raises(AccessDeniedError, match="open for reading only"):
        write(DeviceMemory(Link()))  # type: ignore[arg-type]


def test_a_camera_with_ever_new_settings_takes_no_more_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(change_tracking, "MOST_KNOWN", 3)
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, value=1.0, access=AccessMode.READ_WRITE)
    tracked = ChangeTrackingGrabber(ScriptedGrabber([gain]), ChangeJournal())
    sizes = []
    for number in range(8):
        tracked._remember(SettingKey(f"F{number}"), 1.0)
        sizes.append(len(tracked._known))
    assert sizes == [1, 2, 3, 1, 2, 3, 1, 2]
    tracked.watch(replace(gain, value=2.0))
    assert len(tracked._known) == 3


@pytest.mark.parametrize(
    ("width", "height", "refused"),
    [(1 << 16, 1 << 12, False), ((1 << 16) + 1, 1, True), (1 << 14, (1 << 14) + 1, True)],
)
def test_an_encoded_image_announces_at_most_so_many_pixels(width: int, height: int, refused: bool) -> None:
    assert bool(encoded_image._size_problem(width, height)) is refused


def test_an_encoded_image_of_more_is_not_decoded() -> None:
    head = b"\x89PNG\r\n\x1a\n" + (13).to_bytes(4, "big") + b"IHDR"
    for side, message in ((1 << 14, "cut short"), ((1 << 14) + 1, "at most 268435456 are decoded")):
        size = (1 << 14).to_bytes(4, "big") + side.to_bytes(4, "big")
        file = np.frombuffer(head + size + bytes(9), np.uint8)
        with pytest.raises(RemoteProtocolError, match=message):
            encoded_image.decode(file)
