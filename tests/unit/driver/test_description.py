"""Where a device says its description is, and what may come of it."""

from __future__ import annotations

import io
import os
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gige_transcripts import lines
from grabbergui.core.errors import RemoteProtocolError, TransportError
from grabbergui.driver import description
from grabbergui.driver.description import FOLDER_VARIABLE, LocalFile, fetch_description, parse_url, unpack
from grabbergui.driver.gige.gvcp import Ack

XML = b'<?xml version="1.0"?><RegisterDescription/>'


def zipped(data: bytes, name: str = "camera.xml") -> bytes:
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as writer:
        writer.writestr(name, data)
    return archive.getvalue()


@pytest.mark.parametrize(
    "url, location",
    [
        ("Local:arv-fake-camera.xml;10000;3e67", LocalFile("arv-fake-camera.xml", 0x10000, 0x3E67)),
        ("local:camera.zip;0x40000;0x28DC", LocalFile("camera.zip", 0x40000, 0x28DC)),
        ("Local:///name.zip;40000;28DC", LocalFile("name.zip", 0x40000, 0x28DC)),
        ("Local:gigecamsim.xml; F000; 2B39", LocalFile("gigecamsim.xml", 0xF000, 0x2B39)),
        ("Local:a.xml;1000;20?SchemaVersion=1.1.0", LocalFile("a.xml", 0x1000, 0x20)),
        ("File:///opt/camera%20one.xml", Path("/opt/camera one.xml")),
    ],
)
def test_urls_as_devices_write_them(url: str, location: LocalFile | Path) -> None:
    assert parse_url(url) == location


@pytest.mark.parametrize(
    "url",
    [
        "http://vendor/x.xml",
        "Local:a.xml;1000",
        "Local:a.xml;1000;0",
        "Local:a;0;FFFFFFFF",
        "File://[::1/a.xml",
        "File:///opt/a%00.xml",
        "x",
    ],
)
def test_urls_that_cannot_be_followed(url: str) -> None:
    with pytest.raises(RemoteProtocolError):
        parse_url(url)


@pytest.mark.parametrize("name", ["aravis-open-heartbeat-xml", "aravis-on-viva-open-heartbeat-xml"])
def test_a_captured_device_gives_its_description(name: str) -> None:
    memory: dict[int, bytes] = {}
    for line in lines(name, "S"):
        ack = Ack.decode(line.data)
        if ack.acknowledge == 0x85:
            memory[int.from_bytes(ack.payload[:4], "big")] = ack.payload[4:]

    def read(address: int, length: int) -> bytes:
        data = b""
        while len(data) < length:
            data += memory[address + len(data)]
        return data[:length]

    xml = fetch_description([memory[0x200].rstrip(b"\0").decode()], read)
    assert xml.startswith(b"<?xml") and xml.rstrip().endswith(b"</RegisterDescription>")


def test_the_second_url_is_the_way_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (tmp_path / "camera.zip").write_bytes(zipped(XML))
    urls = ["http://vendor/camera.xml", (tmp_path / "camera.zip").as_uri()]
    assert fetch_description(urls, lambda address, length: b"") == XML
    with pytest.raises(TransportError, match=r"http://vendor/camera.xml.*only Local: and File:"):
        fetch_description(urls[:1], lambda address, length: b"")
    with pytest.raises(TransportError, match="empty"):
        fetch_description(["", ""], lambda address, length: b"")


def fetched(path: Path) -> bytes:
    return fetch_description([path.as_uri()], lambda address, length: b"")


def test_a_camera_reads_no_file_unless_the_user_named_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "camera.xml").write_bytes(XML)
    monkeypatch.delenv(FOLDER_VARIABLE, raising=False)
    with pytest.raises(TransportError, match=f"set {FOLDER_VARIABLE} to its folder"):
        fetched(tmp_path / "camera.xml")


def test_a_camera_reads_only_regular_files_below_that_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    allowed, private = tmp_path / "allowed", tmp_path / "private.xml"
    allowed.mkdir()
    private.write_bytes(XML)
    (allowed / "link.xml").symlink_to(private)
    os.mkfifo(allowed / "fifo.xml")
    (allowed / "large.xml").write_bytes(bytes(101))
    monkeypatch.setattr(description, "MAX_STORED_BYTES", 100)
    monkeypatch.setenv(FOLDER_VARIABLE, str(allowed))

    for path in (private, allowed / ".." / "private.xml", allowed / "link.xml", Path("/dev/zero")):
        with pytest.raises(TransportError, match="is not below"):
            fetched(path)
    with pytest.raises(TransportError, match="not a regular file"):
        fetched(allowed / "fifo.xml")
    with pytest.raises(TransportError, match="too long for a description"):
        fetched(allowed / "large.xml")
    monkeypatch.setenv(FOLDER_VARIABLE, "/dev")
    with pytest.raises(TransportError, match="not a regular file"):
        fetched(Path("/dev/zero"))


def test_plain_and_zipped_are_distinguished_by_content() -> None:
    assert unpack(XML + bytes(3)) == XML
    assert unpack(zipped(XML) + bytes(2)) == XML
    with pytest.raises(RemoteProtocolError, match=r"no \.xml"):
        unpack(zipped(XML, "readme.txt"))


def test_a_zip_bomb_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(description, "MAX_XML_BYTES", 1 << 20)
    with pytest.raises(RemoteProtocolError, match="grows beyond"):
        unpack(zipped(bytes(4 << 20)))


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_what_unpacks_without_bounds_is_refused(method: int) -> None:
    stored = io.BytesIO()
    with zipfile.ZipFile(stored, "w", method) as archive:
        archive.writestr("camera.xml", XML)
    with pytest.raises(RemoteProtocolError, match=f"method {method}"):
        unpack(stored.getvalue())
    # The table at the archive's end says so, and not the member's own head.
    reported = bytearray(zipped(XML))
    reported[reported.index(b"PK\1\2") + 10] = method
    with pytest.raises(RemoteProtocolError, match=f"method {method}"):
        unpack(bytes(reported))


@pytest.mark.parametrize("stored", [b"PK\3\4", b"PK\3\4" + bytes(100)])
def test_a_broken_archive_is_refused(stored: bytes) -> None:
    with pytest.raises(RemoteProtocolError, match="damaged"):
        unpack(stored)


@given(st.binary(max_size=200), st.integers(0, 200))
def test_no_damage_crashes_it(noise: bytes, position: int) -> None:
    for stored in (b"PK\3\4" + noise, zipped(XML)[:position] + noise + zipped(XML)[position + len(noise) :]):
        try:
            unpack(stored)
        except RemoteProtocolError as error:
            assert str(error)
