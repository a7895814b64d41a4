"""What hides or locks a feature: which others, and the values that would not."""

from __future__ import annotations

import pytest

from fakes import XmlDevice
from grabbergui.core.features import AccessCondition, AccessMode
from grabbergui.driver.genapi.node_map import CameraNodeMap

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="F" VendorName="F"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Category Name="Root">"""


def register(name: str, address: int) -> str:
    return (
        f'<IntReg Name="{name}"><Address>{address}</Address><Length>4</Length><AccessMode>RW</AccessMode>'
        "<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
    )


def choice(name: str, address: int, *entries: str) -> str:
    values = "".join(
        f'<EnumEntry Name="{entry}"><Value>{number}</Value></EnumEntry>'
        for number, entry in enumerate(entries)
    )
    return f'<Enumeration Name="{name}">{values}<pValue>{name}Reg</pValue></Enumeration>' + register(
        f"{name}Reg", address
    )


def formula(name: str, text: str, **variables: str) -> str:
    read = "".join(f'<pVariable Name="{symbol}">{node}</pVariable>' for symbol, node in variables.items())
    escaped = text.replace("&", "&amp;").replace("<", "&lt;")
    return f'<IntSwissKnife Name="{name}">{read}<Formula>{escaped}</Formula></IntSwissKnife>'


def dependent(rule: str, node: str) -> str:
    return (
        f'<Integer Name="Dependent"><{rule}>{node}</{rule}><pValue>DependentReg</pValue></Integer>'
        + register("DependentReg", 0x100)
    )


@pytest.fixture
def explained(request):
    """Return access and conditions of the feature `Dependent` of a description."""

    def explain(*nodes: str, **values: int) -> tuple[AccessMode, tuple[AccessCondition, ...]]:
        body = "".join(nodes)
        names = [
            part.partition('"')[0]
            for kind in ("Enumeration", "Integer", "Boolean")
            for part in body.split(f'<{kind} Name="')[1:]
        ]
        features = "".join(f"<pFeature>{name}</pFeature>" for name in names)
        xml = f'{HEAD}{features}</Category>{body}<Port Name="Device"/></RegisterDescription>'.encode()
        device = XmlDevice(xml)
        made = CameraNodeMap(device, xml, lambda names: None)
        request.addfinalizer(made.close)
        for name, value in values.items():
            made.write(name, value)
        device.writes.clear()
        conditions = made.conditions("Dependent")
        assert not device.writes, "nothing is written to find out"
        return made.feature("Dependent").access, conditions

    return explain


MODE = choice("Mode", 0, "Off", "On", "Auto")
SOURCE = choice("Source", 4, "Line1", "Software")


def test_the_value_that_makes_it_available_is_found_by_the_formula(explained):
    assert explained(MODE, formula("Rule", "M > 0", M="ModeReg"), dependent("pIsAvailable", "Rule")) == (
        AccessMode.NOT_AVAILABLE,
        (AccessCondition("Mode", "Off", ("On", "Auto")),),
    )


def test_an_available_feature_has_no_conditions(explained):
    rule = formula("Rule", "M = 0", M="ModeReg")
    assert explained(MODE, rule, dependent("pIsAvailable", "Rule")) == (AccessMode.READ_WRITE, ())


def test_one_that_is_locked_names_what_would_unlock_it(explained):
    rule = formula("Rule", "M = 0", M="Mode")  # over the feature instead of its register
    assert explained(MODE, rule, dependent("pIsLocked", "Rule")) == (
        AccessMode.READ_ONLY,
        (AccessCondition("Mode", "Off", ("On", "Auto")),),
    )


def test_of_two_features_only_the_one_that_must_change_is_named(explained):
    rule = formula("Rule", "(M = 1) && (S = 0)", M="ModeReg", S="SourceReg")
    assert explained(MODE, SOURCE, rule, dependent("pIsAvailable", "Rule")) == (
        AccessMode.NOT_AVAILABLE,
        (AccessCondition("Mode", "Off", ("On",)),),
    )


def test_two_features_are_named_if_both_must_change(explained):
    rule = formula("Rule", "(M = 1) && (S = 1)", M="ModeReg", S="SourceReg")
    assert explained(MODE, SOURCE, rule, dependent("pIsAvailable", "Rule")) == (
        AccessMode.NOT_AVAILABLE,
        (AccessCondition("Mode", "Off", ("On",)), AccessCondition("Source", "Line1", ("Software",))),
    )


def test_a_formula_over_a_formula_is_followed(explained):
    inner, outer = formula("Inner", "M * 2", M="ModeReg"), formula("Rule", "X = 4", X="Inner")
    assert explained(MODE, inner, outer, dependent("pIsAvailable", "Rule"))[1] == (
        AccessCondition("Mode", "Off", ("Auto",)),
    )


def test_a_switch_hides_directly(explained):
    switch = '<Boolean Name="Enable"><pValue>EnableReg</pValue></Boolean>' + register("EnableReg", 8)
    assert explained(switch, dependent("pIsAvailable", "Enable"))[1] == (
        AccessCondition("Enable", "false", ("true",)),
    )


def test_what_is_not_computed_names_the_features_without_values(explained):
    rule = formula("Rule", "M / 3", M="ModeReg")
    assert explained(MODE, rule, dependent("pIsAvailable", "Rule"))[1] == (AccessCondition("Mode", "Off"),)


def test_a_register_without_a_feature_says_nothing(explained):
    assert explained(register("Licence", 12), dependent("pIsAvailable", "Licence")) == (
        AccessMode.NOT_AVAILABLE,
        (),
    )
