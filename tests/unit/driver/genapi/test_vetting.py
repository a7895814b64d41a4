"""Descriptions as cameras deliver them, and those that would freeze or end the program."""

from __future__ import annotations

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes import XmlDevice
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi.cleaning import clean_xml, port_name
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.genapi.vetting import MOST_ENTRIES, MOST_NODES, vetted
from grabbergui.driver.sim.camera_xml import camera_xml

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


@pytest.mark.parametrize("declared", ["ISO-8859-1", "utf-8"])
def test_a_unit_in_latin_1_is_read_as_it_is(declared):
    unit = '<Float Name="X0"><Value>20</Value><Unit>°C</Unit></Float>'
    xml = description(unit).replace("utf-8", declared).encode("latin-1")
    nodes = CameraNodeMap(XmlDevice(xml), xml, lambda names: None)
    assert nodes.feature("X0").unit == "°C"
    nodes.close()


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


def test_finding_the_port_takes_linear_time():
    begun = time.process_time()
    assert port_name("<!--" + 20_000 * "<Port " + '--><Port Name="Camera"/>') == "Camera"
    assert time.process_time() - begun < 10  # a quadratic search takes 80 s


HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="V" VendorName="V"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>"""
SMALLEST_THEN_MINUS_ONE = (1 << 63).to_bytes(8, "big") + b"\xff" * 8


def register(name: str, address: int, inside: str = "") -> str:
    return (
        f'<IntReg Name="{name}"><Address>{address}</Address>{inside}<Length>8</Length>'
        "<AccessMode>RW</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable><Sign>Signed</Sign>"
        "<Endianess>BigEndian</Endianess></IntReg>"
    )


REGISTERS = register("Smallest", 0) + register("MinusOne", 8) + register("Zero", 16)


def description(nodes: str, feature: str = "X0") -> str:
    root = f'<Category Name="Root"><pFeature>{feature}</pFeature></Category>'
    return f"{HEAD}{root}{REGISTERS}{nodes}</RegisterDescription>"


def opened(nodes: str, feature: str = "X0") -> CameraNodeMap:
    device = XmlDevice(description(nodes, feature).encode())
    device.memory.update(enumerate(SMALLEST_THEN_MINUS_ONE))
    return CameraNodeMap(device, device.description(), lambda names: None)


def chain(length: int, reference: str) -> str:
    """Integers, each with `reference` to the next in it."""
    links = "".join(f'<Integer Name="X{i}">{reference.format(f"X{i + 1}")}</Integer>' for i in range(length))
    return f'{links}<Integer Name="X{length}"><Value>1</Value></Integer>'


def test_a_formula_over_live_registers_cannot_end_the_program():
    nodes = opened(
        '<IntSwissKnife Name="X0"><pVariable Name="A">Smallest</pVariable>'
        '<pVariable Name="B">MinusOne</pVariable>'
        "<Formula><![CDATA[A ]]><!-- hidden -->&#47; B</Formula></IntSwissKnife>"
    )
    assert nodes.feature("X0").value == -(2**63)
    nodes.close()


def test_a_converter_over_live_registers_cannot_end_the_program():
    nodes = opened(
        '<IntConverter Name="X0"><pVariable Name="B">MinusOne</pVariable><FormulaTo>FROM / B</FormulaTo>'
        "<FormulaFrom>TO / B</FormulaFrom><pValue>Smallest</pValue></IntConverter>"
    )
    assert nodes.feature("X0").value == -(2**63)
    nodes.close()


@pytest.mark.parametrize(
    "above",
    [
        "<Float Name='X0'><pValue>I</pValue></Float>",
        "<Converter Name='X0'><FormulaTo>FROM</FormulaTo><FormulaFrom>TO</FormulaFrom><pValue>I</pValue>"
        "</Converter>",
    ],
)
@pytest.mark.parametrize("increment", ["<pInc>Zero</pInc>", "<pInc>MinusOne</pInc>", "<Inc>0</Inc>"])
def test_writing_a_float_over_an_integer_without_steps_cannot_end_the_program(above, increment):
    integer = f'<Integer Name="I"><Value>5</Value><Min>0</Min><Max>100</Max>{increment}</Integer>'
    nodes = opened(integer + above)
    nodes.write("X0", 42.0)
    assert nodes.feature("X0").value == 42
    nodes.close()


@pytest.mark.parametrize(
    ("reference", "length"),
    [
        ("<pValue>{}</pValue>", 2500),
        ("<Value>1</Value><pMax>{}</pMax>", 2500),
        ("<pIsAvailable>{}</pIsAvailable><Value>1</Value>", 2500),
        ("<pInvalidator>{}</pInvalidator><Value>1</Value>", 2500),
        ("<Value>1</Value><pSelected>{}</pSelected>", 17),
    ],
)
def test_a_long_chain_is_refused_at_once(reference, length):
    began = time.process_time()
    with pytest.raises(RemoteProtocolError, match=r"follow each other from X\d+, at most"):
        vetted(description(chain(length, reference)))
    assert time.process_time() - began < 5  # GenApi takes 27 s and the GIL for 2,500 of the first


def test_a_feature_tree_that_branches_again_and_again_is_refused():
    """GenApi takes minutes for these 26 categories."""
    lattice = "".join(
        f'<Category Name="K{level}{side}"><pFeature>K{level + 1}A</pFeature>'
        f"<pFeature>K{level + 1}B</pFeature></Category>"
        for level in range(12)
        for side in "AB"
    )
    with pytest.raises(RemoteProtocolError, match=r"leads to \d+ categories, at most 1000"):
        vetted(description(f'{lattice}<Category Name="K12A"/><Category Name="K12B"/>', "K0A"))


def test_a_short_chain_is_none_of_our_business():
    nodes = opened(chain(100, "<pValue>{}</pValue>"))
    assert nodes.feature("X0").value == 1
    nodes.close()


def test_a_register_read_a_million_times_for_one_value_is_refused():
    twice = "<pAddress>X{0}</pAddress><pAddress>X{0}</pAddress>"
    nodes = "".join(register(f"X{i}", 0, twice.format(i + 1)) for i in range(20)) + register("X20", 0)

    with pytest.raises(RemoteProtocolError, match=r"reading X\d+ computes \d+ nodes, at most 100000"):
        vetted(description(nodes))


def test_a_description_of_too_many_nodes_is_refused():
    nodes = "".join(f'<Integer Name="X{i}"><Value>1</Value></Integer>' for i in range(MOST_NODES))
    with pytest.raises(RemoteProtocolError, match=f"more than {MOST_NODES} nodes"):
        vetted(description(nodes))


def test_an_enumeration_of_too_many_entries_is_refused():
    entries = "".join(
        f'<EnumEntry Name="E{i}"><Value>{i}</Value></EnumEntry>' for i in range(MOST_ENTRIES + 1)
    )
    with pytest.raises(RemoteProtocolError, match=f"X0 has more than {MOST_ENTRIES} entries"):
        vetted(description(f'<Enumeration Name="X0">{entries}<Value>1</Value></Enumeration>'))


def test_elements_nested_too_deep_are_refused():
    with pytest.raises(RemoteProtocolError, match="nested more than"):
        vetted(description(f"<Extension>{'<a>' * 1000}{'</a>' * 1000}</Extension>"))


def test_a_cut_integer_increment_between_floats_is_refused():
    nodes = (
        '<Float Name="X0"><pValue>I</pValue></Float><Integer Name="I"><pValue>F</pValue></Integer>'
        '<Float Name="F"><Value>1</Value><Min>0</Min><Max>9</Max><Inc>0.5</Inc></Float>'
    )
    with pytest.raises(RemoteProtocolError, match="a float with an increment"):
        vetted(description(nodes))


def test_the_rest_of_the_text_is_left_alone():
    xml = description(chain(3, "<pValue>{}</pValue>"))
    assert vetted(xml).partition("?>")[2].strip() == xml.partition("?>")[2].strip()


def test_what_is_no_xml_is_refused():
    with pytest.raises(RemoteProtocolError, match="no well-formed XML"):
        vetted("<RegisterDescription>")


def test_a_description_that_is_opened_again_is_not_vetted_again():
    """Reconnecting and changing between cameras open the same few descriptions again and again."""
    xml = camera_xml().decode()
    assert vetted(xml) is vetted(xml + "")
