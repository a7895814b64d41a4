"""The description and the registers are one camera."""

import itertools
from xml.etree import ElementTree

import pytest

from every_case import every_case
from grabbergui import sources
from grabbergui.core.errors import FeatureValueError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.pfnc import Family, by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.camera_xml import camera_xml, with_transport
from grabbergui.driver.sim.enumerations import (
    AcquisitionMode,
    Auto,
    BinningMode,
    Chunk,
    ColorFilter,
    EventSelector,
    File,
    FileOpenMode,
    FileOperation,
    FileOperationStatus,
    FileState,
    PtpStatus,
    TestPattern,
    TransportLayer,
    TriggerActivation,
    TriggerSource,
    UserSetSelector,
)
from grabbergui.driver.sim.memory import Register, RegisterKind
from pixel_formats import CONVERTIBLE

NAMESPACE = "{http://www.genicam.org/GenApi/Version_1_1}"
ROOT = ElementTree.fromstring(camera_xml())
NODES = {node.get("Name"): node for node in ROOT}


def text(node, tag):
    child = node.find(NAMESPACE + tag)
    return None if child is None else child.text


FORMATS = [
    known
    for known in CONVERTIBLE
    if known.family in (Family.MONO, Family.BAYER)
    and known.name.startswith(("Mono", "Bayer"))
    and 8 <= known.depth <= 16
    and known.kind == "u"
    and not known.name.endswith("14p")
]
FORMATS += [
    by_name(name)
    for name in [
        "RGB8",
        "BGR8",
        "RGBa8",
        "BGRa8",
        "YUV422_8",
        "YUV422_8_UYVY",
        "YCbCr422_8",
        "YCbCr422_8_CbYCrY",
    ]
]
"What the description lists; the sensor sends every other format too if its code is written."


@every_case(
    "register",
    [
        Register("DeviceUserID", 0x1000D0, RegisterKind.STRING, 16, ""),
        Register("DeviceVendorName", 0x100000, RegisterKind.STRING, 32, "grabbergui", writable=False),
        Register("Width", 0x100210, RegisterKind.UINT32, 4, 1224, True, 16, 4096, 8, saved=True),
        Register("OffsetY", 0x10021C, RegisterKind.UINT32, 4, 568, True, 0, 2160, 2, saved=True),
        Register("WidthMax", 0x100208, RegisterKind.UINT32, 4, 4096, False),
        Register("GainRaw", 0x100404, RegisterKind.UINT32, 4, 0, True, 0, 2400, saved=True),
        Register(
            "ExposureTime", 0x100330, RegisterKind.FLOAT64, 8, 10_000.0, True, 10.0, 1_000_000.0, saved=True
        ),
        Register("AutoGainUpperLimit", 0x1004A0, RegisterKind.FLOAT64, 8, 24.0, True, 0, 24, saved=True),
        Register("TimestampLatchValue", 0x100130, RegisterKind.INT64, 8, 0, False),
        Register("TestPattern", 0x100244, RegisterKind.UINT32, 4, 0, choices=frozenset(range(9)), saved=True),
        Register("ReverseX", 0x100230, RegisterKind.UINT32, 4, 0, choices=frozenset({0, 1}), saved=True),
        Register("AcquisitionStart", 0x100304, RegisterKind.UINT32, 4, 0),
        Register("UserSetSelector", 0x100600, RegisterKind.UINT32, 4, 0, choices=frozenset({0, 1, 2})),
        Register("BalanceRatio[2]", 0x100430, RegisterKind.FLOAT64, 8, 1.3, True, 0.25, 4.0, saved=True),
        Register("TriggerDelay[1]", 0x100370, RegisterKind.FLOAT64, 8, 0, True, 0, 1_000_000, saved=True),
        Register("EventNotification[3]", 0x10081C, RegisterKind.UINT32, 4, 0, choices=frozenset({0, 1})),
    ],
    ids=lambda register: register.name,
)
def test_registers_are_what_the_description_says(register):
    (found,) = [known for known in reg.ALL if known.name == register.name]
    assert found == register


def test_a_number_that_a_host_writes_is_bounded_on_both_sides():
    for register in reg.ALL:
        if register.writable:
            assert (register.minimum is None) == (register.maximum is None), register.name


def test_no_register_lies_on_another():
    by_address = sorted(reg.ALL, key=lambda register: register.address)
    for register, following in itertools.pairwise(by_address):
        assert register.end <= following.address, following.name


def test_numbers_are_big_endian():
    for node in ROOT:
        if node.tag in (NAMESPACE + "IntReg", NAMESPACE + "FloatReg") and text(node, "pPort") == "Device":
            assert text(node, "Endianess") == "BigEndian", node.get("Name")


@every_case(
    ("feature", "values"),
    [
        ("ExposureAuto", Auto),
        ("GainAuto", Auto),
        ("BalanceWhiteAuto", Auto),
        ("AcquisitionMode", AcquisitionMode),
        ("TriggerSource", TriggerSource),
        ("TriggerActivation", TriggerActivation),
        ("BinningHorizontalMode", BinningMode),
        ("BinningVerticalMode", BinningMode),
        ("TestPattern", TestPattern),
        ("PixelColorFilter", ColorFilter),
        ("ChunkSelector", Chunk),
        ("EventSelector", EventSelector),
        ("UserSetSelector", UserSetSelector),
        ("UserSetDefault", UserSetSelector),
        ("FileSelector", File),
        ("FileOperationSelector", FileOperation),
        ("FileOpenMode", FileOpenMode),
        ("FileOperationStatus", FileOperationStatus),
        ("FileState", FileState),
        ("PtpStatus", PtpStatus),
        ("DeviceTLType", TransportLayer),
    ],
)
def test_numbers_mean_what_the_description_says(feature, values):
    entries = {
        entry.get("Name").upper(): int(text(entry, "Value"), 0)
        for entry in NODES[feature].iter(NAMESPACE + "EnumEntry")
    }
    assert entries == {member.name.replace("_", ""): member.value for member in values}


def test_pixel_formats_have_their_own_codes():
    entries = {
        entry.get("Name"): int(text(entry, "Value"), 0)
        for entry in NODES["PixelFormat"].iter(NAMESPACE + "EnumEntry")
    }
    assert entries == {pixel_format.name: pixel_format.code for pixel_format in FORMATS}


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


CATEGORIES = (
    "DeviceControl",
    "ImageFormatControl",
    "AcquisitionControl",
    "AnalogControl",
    "AutoFunctionControl",
    "DigitalIOControl",
    "LUTControl",
    "UserSetControl",
    "FileAccessControl",
    "Scan3dControl",
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
        "LineSource",
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
