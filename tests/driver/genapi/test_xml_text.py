"""Descriptions as cameras really deliver them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi.xml_text import clean_xml, port_name

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
def test_what_stands_around_the_description_is_cut_off(dump):
    text = clean_xml(dump)

    assert text.startswith(("<?xml", "<RegisterDescription"))
    assert text.endswith("</RegisterDescription>")


def test_latin1_comments_do_not_stop_it():
    assert "RegisterDescription" in clean_xml(b"<!-- \xb5s -->" + BODY)
    assert clean_xml(BODY[:-22] + b"<!-- \xb5s -->" + BODY[-22:])


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
