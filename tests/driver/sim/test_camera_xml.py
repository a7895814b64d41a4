"""The description and the registers are one camera."""

import re
from xml.etree import ElementTree

import pytest

from grabbergui import sources
from grabbergui.core.errors import FeatureValueError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.description import camera_xml, with_transport
from grabbergui.driver.sim.memory import Kind

NAMESPACE = "{http://www.genicam.org/GenApi/Version_1_1}"
ROOT = ElementTree.fromstring(camera_xml())
NODES = {node.get("Name"): node for node in ROOT}
SELECTED = re.compile(r"\[\d\]$")


def text(node, tag):
    child = node.find(NAMESPACE + tag)
    return None if child is None else child.text


def node_of(register):
    name = SELECTED.sub("", register.name)
    return NODES[name if register.kind is Kind.STRING else name + "Reg"]


@pytest.mark.parametrize("register", reg.ALL, ids=lambda register: register.name)
def test_every_register_is_described_as_it_is(register):
    node = node_of(register)
    address = int(text(node, "Address"), 0)
    index = node.find(NAMESPACE + "pIndex")
    if SELECTED.search(register.name):
        address += int(index.get("Offset")) * int(register.name[-2])
    assert address == register.address
    assert int(text(node, "Length")) == register.length
    assert text(node, "AccessMode") == ("RW" if register.writable else "RO")
    assert text(node, "Endianess") == (None if register.kind is Kind.STRING else "BigEndian")
    expected = {Kind.FLOAT64: "FloatReg", Kind.STRING: "StringReg"}.get(register.kind, "IntReg")
    assert node.tag == NAMESPACE + expected


def test_enumerations_offer_what_their_registers_accept():
    registers = {f"{register.name}Reg": register for register in reg.ALL}
    for node in ROOT.iter(NAMESPACE + "Enumeration"):
        register = registers.get(text(node, "pValue"))
        if register is None or not register.writable:
            continue
        values = {int(text(entry, "Value"), 0) for entry in node.iter(NAMESPACE + "EnumEntry")}
        assert values == (register.choices or {0, 1}), node.get("Name")


def test_pixel_formats_have_their_own_codes():
    entries = {
        entry.get("Name"): int(text(entry, "Value"), 0)
        for entry in NODES["PixelFormat"].iter(NAMESPACE + "EnumEntry")
    }
    assert entries == {pixel_format.name: pixel_format.code for pixel_format in reg.SENSOR_FORMATS}


def test_every_feature_explains_itself():
    for category in ROOT.iter(NAMESPACE + "Category"):
        for listed in category.iter(NAMESPACE + "pFeature"):
            node = NODES[listed.text]
            assert text(node, "ToolTip") or listed.text.endswith("Control"), listed.text


def test_nothing_refers_to_a_node_that_is_not_there():
    for element in ROOT.iter():
        tag = element.tag.removeprefix(NAMESPACE)
        if tag.startswith("p") and tag[1:2].isupper():
            assert element.text in NODES, f"{tag} {element.text}"


def test_a_transport_adds_its_features():
    xml = with_transport(("GevX",), b'<Integer Name="GevX"><Value>1</Value></Integer>')
    root = ElementTree.fromstring(xml)
    category = next(node for node in root if node.get("Name") == "TransportLayerControl")
    assert "GevX" in [child.text for child in category]


# -- through GenApi ------------------------------------------------------------------------------

CATEGORIES = (
    "DeviceControl",
    "ImageFormatControl",
    "AcquisitionControl",
    "AnalogControl",
    "AutoFunctionControl",
    "DigitalIOControl",
    "UserSetControl",
    "ChunkDataControl",
    "EventControl",
    "PtpControl",
    "TransportLayerControl",
)


@pytest.fixture
def camera():
    grabber = sources.create("sim:?pixel_format=RGB8")
    grabber.open()
    yield grabber
    grabber.close()


def test_the_tree_has_the_conventions_categories(camera):
    assert tuple(member.name for member in camera.feature_tree().members) == CATEGORIES


def test_no_feature_has_a_problem(camera):
    features = camera.features()
    assert len(features) > 80
    assert [feature.name for feature in features if feature.problem] == []
    hidden = {feature.name for feature in features if feature.access is AccessMode.NOT_AVAILABLE}
    ports = {name for name in hidden if name.startswith(("Chunk", "Event"))}
    assert hidden - ports == {
        "AcquisitionFrameCount",
        "DeviceLinkThroughputLimit",
        "TriggerActivation",
        "TriggerSoftware",
    }


def numbers(feature: Feature) -> bool:
    return feature.kind in (FeatureKind.INTEGER, FeatureKind.FLOAT) and feature.access.writable


def test_every_number_takes_both_ends_of_its_range_and_nothing_beyond(camera):
    names = [feature.name for feature in camera.features() if numbers(feature)]
    assert {"ExposureTime", "Gain", "Width", "OffsetX", "BalanceRatio", "AcquisitionFrameRate"} <= set(names)
    for name in names:
        before = camera.feature(name)
        for value in (before.minimum, before.maximum):
            assert camera.write_feature(name, value).value == pytest.approx(value), name
        after = camera.feature(name)
        for beyond in (after.minimum - 1, after.maximum + 1):
            with pytest.raises(FeatureValueError, match=name):
                camera.write_feature(name, beyond)
        camera.write_feature(name, before.value)


def test_every_choice_can_be_made(camera):
    for feature in camera.features():
        if feature.kind is FeatureKind.ENUMERATION and feature.access.writable:
            for entry in feature.entries:
                if entry.available:
                    assert camera.write_feature(feature.name, entry.name).value == entry.name
            camera.write_feature(feature.name, feature.value)


def test_the_fastest_rate_is_the_same_in_formula_and_camera(camera):
    for exposure, height, limited in ((10.0, 2, "Off"), (9_000.0, 2160, "Off"), (500.0, 1024, "On")):
        camera.write_feature("ExposureTime", exposure)
        camera.write_feature("Height", height)
        camera.write_feature("DeviceLinkThroughputLimitMode", limited)
        camera.write_feature("AcquisitionFrameRateEnable", False)
        fastest = camera.feature("AcquisitionResultingFrameRate").value
        camera.write_feature("AcquisitionFrameRateEnable", True)
        assert camera.feature("AcquisitionFrameRate").maximum == pytest.approx(fastest)


def test_dependent_features_follow(camera):
    camera.write_feature("Width", 640)
    assert camera.feature("OffsetX").maximum == 4096 - 640
    camera.write_feature("PixelFormat", "Mono10p")
    assert camera.feature("PixelSize").value == 10
    assert camera.feature("BalanceRatio").access is AccessMode.NOT_AVAILABLE
    camera.write_feature("AcquisitionMode", "MultiFrame")
    assert camera.feature("AcquisitionFrameCount").access is AccessMode.READ_WRITE


def test_selectors_show_their_own_instance(camera):
    shown = {}
    for colour in ("Red", "Green", "Blue"):
        camera.write_feature("BalanceRatioSelector", colour)
        shown[colour] = camera.feature("BalanceRatio").value
    assert shown == {"Red": 1.6, "Green": 1.0, "Blue": 1.3}
    assert camera.feature("BalanceRatio").selectors == ("BalanceRatioSelector",)


def test_user_sets_through_features(camera):
    camera.write_feature("Gamma", 2.0)
    camera.write_feature("UserSetSelector", "UserSet1")
    camera.execute("UserSetSave")
    camera.write_feature("UserSetSelector", "Default")
    camera.execute("UserSetLoad")
    assert camera.feature("Gamma").value == 1.0
    camera.write_feature("UserSetSelector", "UserSet1")
    camera.execute("UserSetLoad")
    assert camera.feature("Gamma").value == 2.0


def test_exposure_is_locked_by_its_automatic_mode(camera):
    camera.write_feature("ExposureAuto", "Continuous")
    assert camera.feature("ExposureTime").access is AccessMode.READ_ONLY
    camera.write_feature("ExposureTime", 5000)
    assert camera.feature("ExposureAuto").value == "Off"
    assert camera.feature("ExposureTime").value == 5000
