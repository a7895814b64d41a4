"""Descriptions that contradict themselves, or the camera: an odd feature spoils neither others nor itself.

What GenApi cannot load at all (nodes that point nowhere or in a ring) is refused with what is wrong in it.
"""

import math
import resource
import struct
import threading
import time

import pytest

from every_case import every_case
from fakes import XmlDevice
from grabbergui.core.errors import FeatureError, FeatureValueError, RemoteProtocolError
from grabbergui.core.features import AccessMode
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.genapi.register_length import LONGEST_TEXT
from soundness import assert_sound

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="Liar" VendorName="Acme"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>
<Integer Name="Sane"><Value>5</Value><Min>0</Min><Max>10</Max></Integer>
"""
ROOT = '<Category Name="Root"><pFeature>Sane</pFeature><pFeature>Odd</pFeature></Category>'
ZERO, HUNDRED, NAN, SEVENTY_SEVEN, LATIN = 0x00, 0x10, 0x20, 0x30, 0x40
"Addresses, by what lies there."
MEMORY = {
    HUNDRED: (100).to_bytes(4, "big"),
    NAN: struct.pack(">f", math.nan),
    SEVENTY_SEVEN: (77).to_bytes(4, "big"),
    LATIN: "Küche".encode("latin-1"),
}


def register(kind: str, name: str, address: int, length: int = 4) -> str:
    sign = "<Sign>Unsigned</Sign>" if kind == "IntReg" else ""
    order = "" if kind == "StringReg" else f"{sign}<Endianess>BigEndian</Endianess>"
    return (
        f'<{kind} Name="{name}"><Address>{address}</Address><Length>{length}</Length>'
        f"<AccessMode>RW</AccessMode><pPort>Device</pPort>{order}</{kind}>"
    )


def integer(inside: str, address: int = ZERO) -> str:
    return f'<Integer Name="Odd"><pValue>R</pValue>{inside}</Integer>' + register("IntReg", "R", address)


def real(inside: str, address: int = ZERO) -> str:
    return f'<Float Name="Odd"><pValue>R</pValue>{inside}</Float>' + register("FloatReg", "R", address)


def enumeration(inside: str, address: int = ZERO) -> str:
    return f'<Enumeration Name="Odd">{inside}<pValue>R</pValue></Enumeration>' + register(
        "IntReg", "R", address
    )


A_IS_1 = '<EnumEntry Name="A"><Value>1</Value></EnumEntry>'
LIMITS = "<Min>0</Min><Max>10</Max>"
LIMIT_REGISTERS = register("IntReg", "Low", HUNDRED) + register("IntReg", "High", ZERO)

LIES = {
    "no limits": integer(""),
    "limits exchanged": integer("<Min>100</Min><Max>0</Max>"),
    "limits exchanged in the registers": integer("<pMin>Low</pMin><pMax>High</pMax>") + LIMIT_REGISTERS,
    "limits exchanged of a float": real("<Min>100</Min><Max>0</Max>"),
    "no limits of a float": real(""),
    "limits that are no numbers": real("<pMin>N</pMin><pMax>N</pMax>") + register("FloatReg", "N", NAN),
    "one limit that is no number": real("<Min>0</Min><pMax>N</pMax>") + register("FloatReg", "N", NAN),
    "steps of nothing": integer(LIMITS + "<Inc>0</Inc>"),
    "steps of nothing in a register": integer(LIMITS + "<pInc>Z</pInc>") + register("IntReg", "Z", 0x80),
    "steps backwards": integer(LIMITS + "<Inc>-4</Inc>"),
    "steps wider than the range": integer(LIMITS + "<Inc>1000</Inc>"),
    "steps of nothing of a float": real(LIMITS + "<Inc>0</Inc>"),
    "a value beyond the limits": integer(LIMITS, SEVENTY_SEVEN),
    "a value that is no number": real(LIMITS, NAN),
    "the number of no entry": enumeration(A_IS_1, SEVENTY_SEVEN),
    "two entries of one number": enumeration(A_IS_1 + A_IS_1.replace('"A"', '"B"')),
    "neither on nor off": '<Boolean Name="Odd"><pValue>R</pValue><OnValue>1</OnValue><OffValue>0</OffValue>'
    "</Boolean>" + register("IntReg", "R", SEVENTY_SEVEN),
    "text of another encoding": register("StringReg", "Odd", LATIN, 16),
    "read-only text of another encoding": register("StringReg", "Odd", LATIN, 16).replace(">RW<", ">RO<"),
    "text without room": register("StringReg", "Odd", ZERO, 0),
    "text of 100 MB": register("StringReg", "Odd", ZERO, 100_000_000),
    "a register of 9 bytes": register("IntReg", "Odd", ZERO, 9),
    "a float of 5 bytes": register("FloatReg", "Odd", ZERO, 5),
    "a formula that is none": '<IntSwissKnife Name="Odd"><Formula>1+*(</Formula></IntSwissKnife>',
    "a formula that divides by zero": '<SwissKnife Name="Odd"><Formula>1/0</Formula></SwissKnife>',
    "a converter to infinity": '<Converter Name="Odd"><FormulaTo>FROM/0</FormulaTo><FormulaFrom>TO/0'
    "</FormulaFrom><pValue>R</pValue></Converter>" + register("IntReg", "R", ZERO),
    "a limit of no node": integer("<pMin>Nowhere</pMin>"),
    "a selector of no node": integer("<pSelected>Nowhere</pSelected>"),
    "an access rule of no node": '<Integer Name="Odd"><pIsAvailable>Nowhere</pIsAvailable><Value>5</Value>'
    "</Integer>",
    "the value of no node": '<Integer Name="Odd"><pValue>Nowhere</pValue></Integer>',
    "an enumeration without entries": enumeration(""),
    "an entry without a number": enumeration(A_IS_1.replace("<Value>1</Value>", "")),
    "an entry with a number that is none": enumeration(A_IS_1.replace("1", "one")),
    "two entries of one name": enumeration(A_IS_1 + A_IS_1.replace(">1<", ">2<")),
    "a node that selects itself": integer(LIMITS + "<pSelected>Odd</pSelected>"),
    "a node that is computed of itself": '<IntSwissKnife Name="Odd"><pVariable Name="A">Odd</pVariable>'
    "<Formula>A+1</Formula></IntSwissKnife>",
    "a category in itself": '<Category Name="Odd"><pFeature>Root</pFeature></Category>',
    "a category of nothing": '<Category Name="Odd"></Category>',
}


def opened(nodes: str, root: str = ROOT) -> CameraNodeMap:
    device = XmlDevice((HEAD + root + nodes + "</RegisterDescription>").encode())
    for address, content in MEMORY.items():
        device.memory.update(enumerate(content, address))
    return CameraNodeMap(device, device.description(), lambda names: None)


@every_case("nodes", LIES.values(), ids=LIES.keys())
def test_an_odd_feature_is_sound_and_leaves_the_others_alone(nodes):
    node_map = opened(nodes)
    if node_map.has("Odd"):
        odd = node_map.feature("Odd")
        assert_sound(odd)
        for value in (0, 5, -1, 2**70, 1e300, math.nan, "A", "on"):
            try:
                node_map.write("Odd", odd.validated(value))
            except FeatureError as refusal:
                assert str(refusal).startswith("Odd")
        assert_sound(node_map.feature("Odd"))
    assert node_map.feature("Sane").value == 5
    node_map.close()


@pytest.mark.parametrize(
    ("lie", "value"),
    [
        ("limits that are no numbers", 2.5),
        ("a value beyond the limits", 7),
        ("a value that is no number", 2.5),
        ("the number of no entry", "A"),
        ("neither on nor off", True),
        ("text of another encoding", "Bad"),
    ],
)
def test_wrong_values_can_be_corrected(lie, value):
    node_map = opened(LIES[lie])
    node_map.write("Odd", node_map.feature("Odd").validated(value))
    assert node_map.feature("Odd").value == value
    node_map.close()


def test_a_number_without_an_entry_is_shown():
    node_map = opened(LIES["the number of no entry"])
    assert node_map.feature("Odd").value == node_map.value("Odd") == "77"
    node_map.close()


@pytest.mark.parametrize("lie", ["text of another encoding", "read-only text of another encoding"])
def test_text_of_another_encoding_is_read(lie):
    node_map = opened(LIES[lie])
    assert node_map.feature("Odd").value == node_map.value("Odd") == "Küche"
    node_map.close()


def test_what_means_nothing_is_no_value():
    node_map = opened(LIES["neither on nor off"])
    odd = node_map.feature("Odd")
    assert (odd.value, odd.access, odd.problem) == (None, AccessMode.READ_WRITE, "")
    node_map.close()


def test_limits_that_exclude_everything_are_none_and_the_camera_has_the_word():
    node_map = opened(LIES["limits exchanged"])
    odd = node_map.feature("Odd")
    assert (odd.minimum, odd.maximum, odd.range_text()) == (None, None, "a number")
    with pytest.raises(FeatureValueError, match="Odd=5: the camera answered: Value = 5 must be"):
        node_map.write("Odd", odd.validated(5))
    node_map.close()


def test_limits_that_are_not_given_are_not_the_largest_numbers_there_are():
    node_map = opened(LIES["no limits of a float"])
    odd = node_map.feature("Odd")
    assert (odd.minimum, odd.maximum, odd.range_text()) == (None, None, "a number")
    node_map.close()


@pytest.mark.parametrize(
    ("lie", "expected"),
    [
        ("a formula that divides by zero", "Odd: Failed to evaluate formula '1/0': error message is '#Inf"),
        ("text of 100 MB", "its text has 100000000 bytes by the description; at most 262144 make sense"),
        ("a register of 9 bytes", "Value = 9 must be equal or smaller than Max = 8"),
    ],
)
def test_a_problem_says_what_it_is_and_not_where_in_genapi(lie, expected):
    node_map = opened(LIES[lie])
    problem = node_map.feature("Odd").problem
    assert problem.startswith(expected)
    assert "Exception" not in problem
    node_map.close()


@pytest.mark.parametrize("lie", ["steps of nothing", "steps of nothing in a register", "steps backwards"])
def test_an_increment_that_is_not_positive_is_one(lie):
    node_map = opened(LIES[lie])
    odd = node_map.feature("Odd")
    assert (odd.range_text(), odd.increment) == ("0 … 10", 1)
    node_map.write("Odd", odd.validated(7))
    assert node_map.feature("Odd").value == 7
    node_map.close()


@pytest.mark.parametrize("root", ["", '<Integer Name="Root"><Value>5</Value></Integer>'])
def test_a_description_without_a_tree_is_refused(root):
    with pytest.raises(RemoteProtocolError, match="no category Root"):
        opened("", root)


GIGABYTE = "<pLength>Gigabyte</pLength>"
HUGE = 1 << 30


def huge_text(name: str) -> str:
    return register("StringReg", name, ZERO).replace("<Length>4</Length>", GIGABYTE)


def huge(nodes: str, *features: str) -> CameraNodeMap:
    length = f'<Integer Name="Gigabyte"><Value>{HUGE}</Value></Integer>'
    listed = "".join(f"<pFeature>{name}</pFeature>" for name in ("Sane", *features))
    return opened(length + nodes, f'<Category Name="Root">{listed}</Category>')


def peak_mb() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10


def test_sixty_texts_of_a_gigabyte_are_refused_before_anything_is_reserved():
    names = [f"Odd{number}" for number in range(60)]
    node_map = huge("".join(map(huge_text, names)), *names)
    before, begun = peak_mb(), time.process_time()

    features = [node_map.feature(name) for name in names]
    assert node_map.values(names) == {}
    with pytest.raises(FeatureError, match="Odd7: its text has 1073741824 bytes by the description"):
        node_map.write("Odd7", "x")

    assert {feature.problem for feature in features} == {
        f"its text has {HUGE} bytes by the description; at most {LONGEST_TEXT} make sense"
    }
    assert peak_mb() - before < 100  # one of them needs 1,024
    assert time.process_time() - begun < 2
    assert node_map.feature("Sane").value == 5
    node_map.close()


def test_text_of_a_gigabyte_behind_another_node_is_refused():
    node_map = huge(huge_text("Text") + '<String Name="Odd"><pValue>Text</pValue></String>', "Odd")
    before = peak_mb()
    assert node_map.feature("Odd").problem.startswith(f"its text has {HUGE} bytes")
    assert peak_mb() - before < 100
    node_map.close()


def test_the_longest_text_is_written_on_a_small_stack():
    """GenApi reserves the register on the stack: beyond it, a write ends the program."""
    odd = register("StringReg", "Odd", ZERO, LONGEST_TEXT)
    node_map = opened(odd)
    old = threading.stack_size(1 << 20)
    try:
        thread = threading.Thread(target=node_map.write, args=("Odd", "long"))
        thread.start()
        thread.join()
    finally:
        threading.stack_size(old)
    assert node_map.feature("Odd").value == "long"
    node_map.close()


def test_a_register_of_a_gigabyte_is_neither_read_nor_written():
    node_map = huge(huge_text("Odd").replace("StringReg", "Register"), "Odd")
    before = peak_mb()
    for use in (
        lambda: node_map.register_length("Odd"),
        lambda: node_map.read_register("Odd", HUGE),
        lambda: node_map.write_register("Odd", b"x"),
    ):
        with pytest.raises(RemoteProtocolError, match=f"Odd has {HUGE} bytes by the description"):
            use()
    assert peak_mb() - before < 100
    node_map.close()
