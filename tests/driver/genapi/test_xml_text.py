"""Descriptions as cameras really deliver them."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi import port
from grabbergui.driver.genapi.vetting import clean_xml, port_name

BODY = b'<RegisterDescription ModelName="M"><Port Name="Device"/></RegisterDescription>'


@pytest.mark.parametrize(
    "dump",
    [
        BODY,
        b'<?xml version="1.0"?>' + BODY,
        b"Dump of camera 12\n" + BODY,
        b"\xef\xbb\xbf" + BODY,
        BODY + b"\0\0\0\r\n",
        b"junk <" + b'<?xml version="1.0"?>' + BODY + b"\0trailing",
    ],
)
def test_text_around_the_description_is_cut_off(dump):
    text = clean_xml(dump)

    assert text.startswith(("<?xml", "<RegisterDescription"))
    assert text.endswith("</RegisterDescription>")


def test_latin1_comments_do_not_stop_it():
    assert "RegisterDescription" in clean_xml(b"<!-- \xb5s -->" + BODY)
    assert clean_xml(BODY[:-22] + b"<!-- \xb5s -->" + BODY[-22:])


@pytest.mark.parametrize(
    ("vendors", "tidied"),
    [
        (b"<Visibility>\n  Beginner </Visibility>", "<Visibility>Beginner</Visibility>"),
        (b"<AccessMode> RW</AccessMode>", "<AccessMode>RW</AccessMode>"),
        (
            b"<Description>Long.</Description>\n<ToolTip>Short</ToolTip>",
            "<ToolTip>Short</ToolTip>\n<Description>Long.</Description>",
        ),
        (b"<ToolTip> as it is </ToolTip>", "<ToolTip> as it is </ToolTip>"),
    ],
)
def test_slips_that_viewers_tolerate_are_mended(vendors, tidied):
    assert clean_xml(BODY[:-22] + vendors + BODY[-22:]) == (
        BODY[:-22].decode() + tidied + BODY[-22:].decode()
    )


def test_genapi_loads_what_was_mended():
    xml = (Path(__file__).parents[2] / "data" / "genapi" / "test_camera.xml").read_text()
    slips = xml.replace("<Visibility>Guru</Visibility>", "<Visibility> Guru\n</Visibility>")
    assert slips != xml

    assert port.load(clean_xml(slips.encode())).has_node("Width")


def test_entities_are_refused():
    bomb = b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + BODY

    with pytest.raises(RemoteProtocolError, match="entities"):
        clean_xml(bomb)


@given(st.binary(max_size=200))
def test_other_bytes_are_refused(data):
    with pytest.raises(RemoteProtocolError, match="no GenICam XML"):
        clean_xml(data.replace(b"<", b" "))


def test_the_device_port_is_preferred():
    assert port_name('<Port Name="ChunkPort"/><Port Name="Device">') == "Device"
    assert port_name('<Port Name="Camera"/>') == "Camera"
    assert port_name("") == "Device"
