"""What a camera stores or appends: URLs, archives, XML, chunks; and configuration files."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from fuzz._input import DATA, Input, erring, refusing
from grabbergui.config import ini
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi import chunk_reader, xml_text
from grabbergui.driver.gige.description import fetch_description, parse_url
from grabbergui.driver.stored_description import unpack

URLS = (
    b"Local:arv-fake-camera.xml;10000;3e67",
    b"local:///name.zip;0x40000;28DC?SchemaVersion=1.1.0",
    b"Local:gigecamsim.xml; F000; 2B39",
    b"File:///etc/hostname",
    b"http://vendor.example/camera.xml",
)


def seeds() -> list[bytes]:
    """URLs as cameras have them, a small archive, a small description, chunks."""
    xml = (DATA / "genapi" / "test_camera.xml").read_bytes()[:3000]
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as opened:
        opened.writestr("camera.xml", b"<?xml version='1.0'?><RegisterDescription/>")
    chunks = bytes(16) + b"\0\0\0\1\0\0\0\x10" + bytes(8) + b"\0\0\0\2\0\0\0\x08"
    return [
        *(b"\0" + url for url in URLS),
        b"\1" + archive.getvalue(),
        b"\2" + xml,
        b"\3" + chunks,
        b"\4[CAMERA]\nname = /grabber // a comment\nwidth 640\n",
    ]


def one_input(data: bytes) -> None:
    """One part's turn, by the first byte."""
    source = Input(data)
    (_url, _archive, _xml, _chunks, _ini)[source.number(1) % 5](source)


def _url(source: Input) -> None:
    text = source.rest().decode("utf-8", "replace")
    refusing(parse_url, text)
    if text.strip().lower().startswith("local:"):
        erring(fetch_description, [text], lambda address, length: bytes(length))


def _archive(source: Input) -> None:
    refusing(unpack, b"PK\3\4" + source.rest().removeprefix(b"PK\3\4"))


def _xml(source: Input) -> None:
    text = refusing(xml_text.clean_xml, source.rest())
    if text is not None:
        xml_text.port_name(text)
        if "<!ENTITY" in text or "<!DOCTYPE" in text:
            raise AssertionError("an entity went through")


def _chunks(source: Input) -> None:
    payload = np.frombuffer(source.rest(), np.uint8)
    for layout in DataLayout:
        kept = chunk_reader.without_pictures(payload, layout)
        if len(kept) > len(payload):
            raise AssertionError(kept)


def _ini(source: Input) -> None:
    erring(ini.parse, source.rest().decode("utf-8", "replace"))
