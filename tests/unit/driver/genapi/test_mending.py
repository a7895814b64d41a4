"""Descriptions with slips: GenApi takes them, and at most the faulty node or entry is missing."""

from __future__ import annotations

import re
import time
from xml.etree import ElementTree

import pytest

from fakes import XmlDevice
from grabbergui.driver.genapi.mending import mended
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.sim.camera_xml import camera_xml

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="V" VendorName="V"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>"""
OTHER = '<Integer Name="Other"><pValue>Gain</pValue></Integer>'
WIDTH = '<Integer Name="Width"><Value>64</Value></Integer>'


def description(nodes: str, *features: str) -> str:
    listed = "".join(f"<pFeature>{name}</pFeature>" for name in features)
    return f'{HEAD}<Category Name="Root">{listed}</Category>{nodes}</RegisterDescription>'


@pytest.fixture
def opened():
    maps = []

    def open_map(nodes: str, *features: str) -> CameraNodeMap:
        xml = description(nodes, *features).encode()
        maps.append(CameraNodeMap(XmlDevice(xml), xml, lambda names: None))
        return maps[-1]

    yield open_map
    for nodes in maps:
        nodes.close()


@pytest.mark.parametrize(
    ("vendors", "tidied"),
    [
        ("<Visibility>\n  Beginner </Visibility>", "<Visibility>Beginner</Visibility>"),
        ("<pValue>\n  Width\n</pValue>", "<pValue>Width</pValue>"),
        ("<ToolTip>\n  as it is\n</ToolTip>", "<ToolTip>as it is</ToolTip>"),
        (
            "<Visibility>Guru</Visibility><Description>Long.</Description><ToolTip>Short</ToolTip>",
            "<ToolTip>Short</ToolTip><Description>Long.</Description><Visibility>Guru</Visibility>",
        ),
    ],
)
def test_slips_that_viewers_tolerate_are_mended(vendors, tidied):
    node = '<Integer Name="E">{}</Integer>' + WIDTH

    assert node.format(tidied) in mended(description(node.format(vendors)))


@pytest.mark.parametrize("text", ["<ToolTip> as it is </ToolTip><Value>1</Value>", "<Value>1</Value>"])
def test_what_has_no_fault_stays_the_same_text(text):
    xml = description(f'<!-- by hand --><Integer Name="E">{text}</Integer>')

    assert mended(xml) is xml


def test_entries_with_illegal_names_are_shown_and_written_as_they_are(opened):
    entries = "".join(
        f'<EnumEntry Name="{name}"><Value>{value}</Value></EnumEntry>'
        for value, name in enumerate(["UTC-12:00", "UTC+12:00", "UTC", "E_UTC", ""])
    )
    nodes = opened(f'<Enumeration Name="Zone">{entries}<Value>0</Value></Enumeration>', "Zone")

    assert nodes.feature("Zone").value == "UTC-12:00"
    nodes.write("Zone", "UTC+12:00")
    assert nodes.feature("Zone").value == "UTC+12:00"
    assert [entry.name for entry in nodes.feature("Zone").entries][:4] == [
        "UTC-12:00",
        "UTC+12:00",
        "UTC",
        "E_UTC",
    ]


def test_the_second_of_two_entries_of_one_name_is_dropped(opened):
    entries = '<EnumEntry Name="A"><Value>{}</Value></EnumEntry>'
    nodes = opened(
        f'<Enumeration Name="E">{entries.format(0)}{entries.format(1)}<Value>0</Value></Enumeration>', "E"
    )

    assert [entry.name for entry in nodes.feature("E").entries] == ["A"]


def test_a_missing_feature_costs_that_feature(opened, caplog):
    nodes = opened(WIDTH, "Missing", "Width")

    assert nodes.feature("Width").value == 64
    assert not nodes.has("Missing")
    assert "Root refers to Missing" in caplog.text


@pytest.mark.parametrize(
    "faulty",
    [
        '<Integer Name="Gain"><pValue>Missing</pValue></Integer>',
        '<Integer Name="Gain"><pValue>Between</pValue></Integer>'
        '<IntSwissKnife Name="Between"><pVariable Name="A">Missing</pVariable><Formula>A</Formula>'
        "</IntSwissKnife>",
        '<IntReg Name="Gain"><Address>0</Address><Length>4</Length><AccessMode>RW</AccessMode>'
        "<pPort>Missing</pPort><Sign>Signed</Sign><Endianess>BigEndian</Endianess></IntReg>",
        '<Integer Name="Gain"><pValue/></Integer>',
    ],
)
def test_a_node_that_needs_a_missing_one_is_dropped_with_all_that_need_it(opened, faulty):
    nodes = opened(WIDTH + faulty, "Gain", "Width")

    assert nodes.feature("Width").value == 64
    assert not nodes.has("Gain")


@pytest.mark.parametrize(
    "faulty",
    [
        '<Integer Name="Gain"><pValue>Gain</pValue></Integer>',
        f'<Integer Name="Gain"><pValue>Other</pValue></Integer>{OTHER}',
        '<IntSwissKnife Name="Gain"><pVariable Name="X">Other</pVariable><Formula>X</Formula></IntSwissKnife>'
        + OTHER,
    ],
)
def test_a_node_that_needs_itself_is_dropped_with_all_that_need_it(opened, faulty, caplog):
    nodes = opened(WIDTH + faulty, "Gain", "Width")

    assert nodes.feature("Width").value == 64
    assert not nodes.has("Gain")
    assert "needs itself" in caplog.text


@pytest.mark.parametrize(
    ("inside", "other"),
    [
        ("<Value>5</Value><pMin>Other</pMin>", OTHER),
        (
            "<pIsLocked>Other</pIsLocked><Value>5</Value>",
            '<Integer Name="Other"><pValue>Gain</pValue></Integer>',
        ),
        (
            "<Value>5</Value><pSelected>Other</pSelected>",
            '<Integer Name="Other"><Value>1</Value><pSelected>Gain</pSelected></Integer>',
        ),
        (
            "<Value>5</Value>",
            '<Category Name="C"><pFeature>D</pFeature></Category>'
            '<Category Name="D"><pFeature>C</pFeature></Category>',
        ),
    ],
)
def test_a_cycle_that_a_node_can_do_without_costs_only_the_reference(opened, inside, other):
    nodes = opened(f'<Integer Name="Gain">{inside}</Integer>{other}', "Gain")

    assert nodes.feature("Gain").value == 5
    nodes.write("Gain", 7)
    assert nodes.feature("Gain").value == 7


def test_many_long_cycles_take_little_time():
    count = 20_000
    chain = "".join(
        f'<Integer Name="N{at}"><pMin>N0</pMin><pValue>N{at + 1}</pValue></Integer>' for at in range(count)
    )
    began = time.process_time()

    text = mended(description(chain + f'<Integer Name="N{count}"><Value>1</Value></Integer>', "N1"))

    assert "N0</pMin>" not in text
    assert time.process_time() - began < 5


def test_a_missing_limit_or_lock_costs_only_itself(opened):
    inside = "<pIsLocked>Missing</pIsLocked><Value>5</Value><pMax>Missing</pMax>"
    nodes = opened(f'<Integer Name="Gain">{inside}</Integer>', "Gain")

    assert nodes.feature("Gain").value == 5
    nodes.write("Gain", 7)
    assert nodes.feature("Gain").value == 7


@pytest.mark.parametrize(
    "inside",
    [
        "<Visibility>beginner</Visibility><Value>5</Value>",
        "<Visibility>Everybody</Visibility><Value>5</Value>",
        "<Value>5</Value><Max>0xFFFFFFFFFFFFFFFF</Max>",
        "<Value>5</Value><Min>none</Min><Representation>HEXNUMBER</Representation>",
        "<Streamable>true</Streamable><Value>0x5</Value>",
    ],
)
def test_what_a_node_can_do_without_costs_only_itself(opened, inside):
    nodes = opened(f'<Integer Name="Gain">{inside}</Integer>', "Gain")

    assert nodes.feature("Gain").value == 5
    nodes.write("Gain", 7)
    assert nodes.feature("Gain").value == 7


@pytest.mark.parametrize("value", ["five", "1.5", "", "0xFFFFFFFFFFFFFFFFF", "-0x5", "9" * 50_000])
def test_a_value_that_is_no_integer_costs_its_node(opened, value):
    nodes = opened(f'<Integer Name="Gain"><Value>{value}</Value></Integer>{WIDTH}', "Gain", "Width")

    assert nodes.feature("Width").value == 64
    assert not nodes.has("Gain")


@pytest.mark.parametrize(("written", "meant"), [("rw", True), ("Ro", False), ("ReadOnly", None)])
def test_the_access_mode_of_a_register(opened, written, meant):
    register = (
        f'<IntReg Name="Gain"><Address>0</Address><Length>4</Length><AccessMode>{written}</AccessMode>'
        "<pPort>Device</pPort><Sign>unsigned</Sign><Endianess>bigendian</Endianess></IntReg>"
    )
    nodes = opened(register + WIDTH, "Gain", "Width")

    assert nodes.feature("Width").value == 64
    assert (nodes.feature("Gain").access.writable if nodes.has("Gain") else None) is meant


def test_of_two_nodes_of_one_name_the_first_is_used(opened):
    nodes = opened(WIDTH + WIDTH.replace("64", "65"), "Width")

    assert nodes.feature("Width").value == 64


def test_a_formatter_changes_nothing():
    """Every element on lines of its own, as some editors and version control hooks leave it."""
    original = camera_xml()
    spread = re.sub(rb">([^<>]*[^<>\s][^<>]*)</", rb">\n      \1\n    </", original)
    assert spread.count(b"\n") > original.count(b"\n") + 1000

    def features(xml: bytes) -> dict[str, object]:
        nodes = CameraNodeMap(XmlDevice(xml), xml, lambda names: None)
        found = {item.name: nodes.feature(item.name) for item in nodes.root.descriptions()}
        nodes.close()
        return found

    assert features(spread) == features(original)


def test_many_faults_take_little_time():
    begun = time.process_time()
    listed = [f"Missing{number}" for number in range(50_000)]
    root = ElementTree.fromstring(mended(description(WIDTH, *listed, "Width")))
    assert len(root[1]) == 1
    assert time.process_time() - begun < 20


def test_elements_nested_very_deep_are_left_to_vetting():
    xml = description(f"<Extension>{'<a>' * 50_000}{'</a>' * 50_000}</Extension>", "Missing")

    assert mended(xml) == xml
