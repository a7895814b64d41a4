"""Names, serial numbers and addresses are replaced everywhere, and alike."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable

from grabbergui import sources
from grabbergui.cli import features as features_command
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.twin import report_file
from grabbergui.driver.twin.device import device_of
from grabbergui.driver.twin.report_file import CameraReport, RecordedAccess
from grabbergui.report import stand_ins
from grabbergui.report.stand_ins import without_names

SERIAL, NAME, MAC, IP = "22ab34455", "Ana's left eye", "00:30:53:0a:0b:0c", "192.168.7.9"
HOST = "192.168.7.1"


def register(address: int, data: bytes, name: str = "") -> RecordedAccess:
    return RecordedAccess(address, len(data), data, name=name)


def ip(text: str) -> bytes:
    return bytes(map(int, text.split(".")))


REPORT = CameraReport(
    DeviceInfo(f"gige:{SERIAL}", "Acme", "Eye", SERIAL, "GigE Vision", IP, NAME, "1.2.3.4", MAC),
    description=(
        b"<x><!-- made for 22ab34455 --><Node Name='Left'><ToolTip>Ana's left eye</ToolTip>"
        b"<pValue>Ana</pValue><Value>22ab34455</Value></Node>\xe9</x>"
    ),
    bootstrap=(
        register(0x8, b"\0\0\x00\x30", "MAC_HIGH"),
        register(0xC, b"\x53\x0a\x0b\x0c", "MAC_LOW"),
        register(0x24, ip(IP), "CURRENT_IP"),
        register(0xA14, ip(HOST), "PRIMARY_APPLICATION_IP"),
        register(0xD8, SERIAL.encode().ljust(16, b"\0"), "SERIAL_NUMBER"),
    ),
    registers=(
        register(0x1000, NAME.encode().ljust(32, b"\0"), "DeviceUserID"),
        register(0x2000, b"\x0c\x0b\x0a\x53\x30\x00\0\0", "little-endian"),
        RecordedAccess(0x3000, 4, failure="DeviceStatusError", message=f"{SERIAL} refused"),
        register(0x4000, b"\0\0\0\x01", "a number"),
    ),
    features=(
        {"name": "DeviceUserID", "kind": "string", "value": NAME, "problem": ""},
        {"name": "GevMACAddress", "kind": "integer", "value": 0x0030530A0B0C, "problem": ""},
        {"name": "GevCurrentIPAddress", "kind": "integer", "value": 0xC0A80709, "problem": ""},
    ),
    problems=(f"opening: {IP} did not answer",),
    computer={
        "discovery": [{"serial": "7", "mac": "00:30:53:0A:0B:0D", "ip": "192.168.7.10", "gateway": HOST}],
        "doctor": [{"level": "ok", "text": f"Acme at {IP}", "remedy": "ping 10.9.8.7"}],
    },
    log=f"controls {SERIAL} at {IP}; version 1.2.3.4 by {MAC.upper()} and {MAC.replace(':', '')}\n",
)


def members(report: CameraReport) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(report_file.encode(report))) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_no_name_is_left_in_any_member() -> None:
    content = b"\n".join(members(without_names(REPORT)).values())
    texts = (SERIAL, NAME, MAC, MAC.upper(), MAC.replace(":", ""), IP, HOST, "192.168.7.10", "10.9.8.7")
    secrets = [text.encode() for text in texts]
    secrets += [text.encode().hex().encode() for text in (SERIAL, NAME)]
    secrets += [ip(IP).hex().encode(), b"530a0b0c", b"0c0b0a53", str(0xC0A80709).encode()]
    assert [secret for secret in secrets if secret in content] == []


def test_a_name_has_one_stand_in_and_addresses_keep_their_network() -> None:
    hidden = without_names(REPORT)
    known = {each.name: each.data for each in (*hidden.bootstrap, *hidden.registers)}
    serial = hidden.info.serial
    assert len(serial) == len(SERIAL) and hidden.info.uri == f"gige:{serial}"
    assert known["SERIAL_NUMBER"] == serial.encode().ljust(16, b"\0")
    assert f"controls {serial} at {hidden.info.address}; version" in hidden.log
    assert f"made for {serial} " in hidden.description.decode("latin-1")
    assert known["CURRENT_IP"] == ip(hidden.info.address)
    ours, theirs = known["PRIMARY_APPLICATION_IP"], known["CURRENT_IP"]
    assert ours[:3] == theirs[:3] and ours != theirs
    mac = bytes.fromhex(hidden.info.hardware_id.replace(":", ""))
    assert known["MAC_HIGH"][2:] + known["MAC_LOW"] == mac == known["little-endian"][5::-1]
    assert hidden.features[1]["value"] == int.from_bytes(mac, "big")
    assert known["DeviceUserID"].rstrip(b"\0").decode() == hidden.info.user_name


def test_everything_else_stays() -> None:
    hidden = without_names(REPORT)
    assert (hidden.info.vendor, hidden.info.model, hidden.info.version) == ("Acme", "Eye", "1.2.3.4")
    assert b"<pValue>Ana</pValue>" in hidden.description and b"Name='Left'" in hidden.description
    assert b"\xe9" in hidden.description, "whatever its encoding"
    assert hidden.registers[-1] == REPORT.registers[-1]
    assert [each.length for each in hidden.registers] == [each.length for each in REPORT.registers]


def test_this_computers_names_are_replaced_in_its_texts(monkeypatch) -> None:
    monkeypatch.setattr(stand_ins.socket, "gethostname", lambda: "anaslaptop")
    monkeypatch.setattr(stand_ins, "_user", lambda: "anabel")
    monkeypatch.setattr(stand_ins, "home", lambda: "/home/anabel")
    log = "wrote /home/anabel/x on anaslaptop for anabel\n"
    hidden = without_names(CameraReport(DeviceInfo("sim:"), log=log))
    assert hidden.log == "wrote ~/x on computer for user\n"


def test_a_user_name_that_is_a_word_of_the_description_breaks_nothing() -> None:
    """The user calls the camera `Continuous`, as an entry is called, or like its model."""
    description = (
        b"<Enumeration Name='Mode'><ToolTip>Continuous</ToolTip><EnumEntry Name='Continuous'/></Enumeration>"
    )
    rows = ({"name": "Mode", "kind": "enumeration", "value": "Continuous", "problem": ""},)
    info = DeviceInfo("u3v:", "Acme", "Eye", user_name="Continuous")
    hidden = without_names(CameraReport(info, description=description, features=rows))
    assert b"EnumEntry Name='Continuous'" in hidden.description and hidden.features == rows
    assert b"<ToolTip>Continuous" not in hidden.description
    alike = CameraReport(DeviceInfo("u3v:", "Acme", "Continuous", user_name="Continuous"), log="Continuous")
    assert without_names(alike).log == "Continuous"


def test_a_twin_with_stand_ins_differs_in_names_alone(report_of: Callable[..., CameraReport]) -> None:
    report = report_of(sources.create("sim:?serial=SIM777123&user_id=front%20door"), frames=0)
    rows = []
    for each in (report, without_names(report)):
        camera = DeviceGrabber(device_of(each, "twin:", answer_times=False))
        camera.open(Access.CONTROL)
        rows.append([features_command._as_dict(feature) for feature in camera.features()])
        camera.close()
    names = {before["name"] for before, after in zip(*rows, strict=True) if before != after}
    assert names == {"DeviceSerialNumber", "DeviceUserID"}
    assert "front door" not in json.dumps(rows[1])
