"""Data of a camera: URLs, archives, XML, chunks; and configuration files.

GenApi loads, reads and writes what the vetting accepts: a trap ends the fuzzer, which keeps the input.
"""

from __future__ import annotations

import contextlib
import io
import time
import zipfile
from typing import cast

import numpy as np
from genicam import genapi

from fuzz._descriptions import HEAD, Registers, description, formula
from fuzz._input import DATA, Input, erring, refusing
from grabbergui.config.ini_files import parse_ini
from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureKind
from grabbergui.driver.description import fetch_description, parse_url, unpack
from grabbergui.driver.device import DataLayout, Device
from grabbergui.driver.genapi import node_features
from grabbergui.driver.genapi.chunk_reader import without_images
from grabbergui.driver.genapi.cleaning import clean_xml, port_name
from grabbergui.driver.genapi.formulas import without_traps
from grabbergui.driver.genapi.loading import load
from grabbergui.driver.genapi.port import RegisterPort

URLS = (
    b"Local:arv-fake-camera.xml;10000;3e67",
    b"local:///name.zip;0x40000;28DC?SchemaVersion=1.1.0",
    b"Local:gigecamsim.xml; F000; 2B39",
    b"File:///etc/hostname",
    b"http://vendor.example/camera.xml",
)

LONGEST = 3.0
"Seconds of computing that a small description may take."


def seeds() -> list[bytes]:
    """Return cameras' URLs, a small archive, a small description, and chunks."""
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
        *(b"\5" + bytes([pick] * 200) for pick in (3, 37, 101, 255)),
        b"\6" + bytes(range(60)),
        b"\4[CAMERA]\nname = /grabber // a comment\nwidth 640\n",
    ]


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    parts = (_url, _archive, _xml, _chunks, _ini, _description, _formula)
    parts[source.number(1) % len(parts)](source)


def _url(source: Input) -> None:
    text = source.rest().decode("utf-8", "replace")
    refusing(parse_url, text)
    if text.strip().lower().startswith("local:"):
        erring(fetch_description, [text], lambda address, length: bytes(length))


def _archive(source: Input) -> None:
    refusing(unpack, b"PK\3\4" + source.rest().removeprefix(b"PK\3\4"))


def _xml(source: Input) -> None:
    text = refusing(clean_xml, source.rest())
    if text is not None:
        port_name(text)
        if "<!ENTITY" in text or "<!DOCTYPE" in text:
            raise AssertionError("an entity went through")


def _chunks(source: Input) -> None:
    payload = np.frombuffer(source.rest(), np.uint8)
    for layout in DataLayout:
        kept = without_images(payload, layout)
        if len(kept) > len(payload):
            raise AssertionError(kept)


def _ini(source: Input) -> None:
    erring(parse_ini, source.rest().decode("utf-8", "replace"))


def _description(source: Input) -> None:
    """Load a whole description, and read and write every node, twice."""
    registers = Registers(source.take(24))
    began = time.process_time()
    try:
        nodes = load(description(source))
        port = RegisterPort(cast(Device, registers))
        nodes.connect(port, "Device")
    except (genapi.GenericException, RuntimeError, GrabberError):
        return
    for value in (0, -(1 << 63), 1.5):
        for node in nodes.nodes:
            use(node, value)
    if time.process_time() - began > LONGEST:
        raise AssertionError(f"{time.process_time() - began:.1f} s for one description")


def use(node: object, value: float) -> None:
    """Read a node and write a value to it, as its access allows."""
    known = node_features.describe(getattr(node, "node", node), "")
    if known is None:
        return
    feature = node_features.NodeFeature(node, known, None)
    if feature.snapshot().kind is FeatureKind.COMMAND:
        return  # executed, never written
    with contextlib.suppress(genapi.GenericException, RuntimeError, TypeError, OverflowError, ValueError):
        feature.assign(value)


def _formula(source: Input) -> None:
    """Evaluate one integer formula with the two numbers that trap."""
    text = without_traps(formula(source, 40)).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    nodes = genapi.NodeMap()
    constants = f'<Constant Name="A">{-(1 << 63)}</Constant><Constant Name="B">-1</Constant>'
    knife = f'<IntSwissKnife Name="X">{constants}<Formula>{text}</Formula></IntSwissKnife>'
    with contextlib.suppress(genapi.GenericException, RuntimeError):
        nodes.load_xml_from_string(f'{HEAD}<Category Name="Root"/>{knife}</RegisterDescription>')
        _ = nodes.get_node("X").value
