"""Our parameters stand everything that rqt_reconfigure and `ros2 param` do with a node's."""

import itertools
from contextlib import closing
from dataclasses import replace

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from rcl_interfaces.msg import Parameter, ParameterEvent  # noqa: E402
from rclpy.parameter import parameter_value_to_python  # noqa: E402

from fakes import ScriptedGrabber  # noqa: E402
from grabbergui import sources  # noqa: E402
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_peers import ParameterProbe, until  # noqa: E402

INFINITE = float("inf")


def number(name, low, high, value=None, kind=FeatureKind.FLOAT, **more):
    value = low if value is None else value
    return Feature(
        name=name, kind=kind, access=AccessMode.READ_WRITE, value=value, minimum=low, maximum=high, **more
    )


def integer(name, low, high, value=None):
    return number(name, low, high, value, FeatureKind.INTEGER)


def slider_positions(descriptor):
    """Where rqt_reconfigure puts the ends of a slider, as it reckons."""
    for span in descriptor.integer_range:
        return span.from_value, span.to_value
    for span in descriptor.floating_point_range:
        scale = 100 / (span.to_value - span.from_value)
        return round(span.from_value * scale), round(span.to_value * scale)
    return 0, 0


@pytest.fixture
def scripted(domain):
    """Serves features, and gives their grabber and a client of the parameters."""
    closers = []

    def scripted(*features):
        grabber = ScriptedGrabber(features)
        server = Ros2GrabberServer(grabber, "/scripted")
        server.start()
        closers.append(server.stop)
        probe = ParameterProbe("/scripted")
        closers.append(probe.close)
        return grabber, probe

    yield scripted
    for close in reversed(closers):
        close()


@pytest.fixture
def events_of():
    """The parameter events of a node, from the moment at which they certainly arrive."""

    def events_of(probe, grabber):
        events = probe.subscribe(ParameterEvent, "/parameter_events", 100)

        turns = itertools.cycle((1, 2))

        def heard():  # an event says what has changed
            grabber.known["Marker"] = replace(grabber.known["Marker"], value=next(turns))
            grabber.features_changed.emit(frozenset(["Marker"]))
            return not events.empty()

        until(heard)
        return events

    return events_of


def reported_of(events, name):
    """How a parameter fared, and its value, in the next event that has it."""
    while True:
        event = events.get(timeout=PATIENCE)
        for how in ("new", "changed", "deleted") if event.node == "/scripted" else ():
            for parameter in getattr(event, f"{how}_parameters"):
                if parameter.name == name:
                    return how, parameter_value_to_python(parameter.value)


def test_every_range_of_a_camera_fits_on_a_slider_and_every_type_is_its_values(domain):
    camera = sources.create("sim:?width=64&height=48&pixel_format=BayerRG8")
    camera.open()
    with (
        closing(camera),
        Ros2GrabberServer(camera, "/cam"),
        closing(ParameterProbe("/cam")) as probe,
    ):
        names = probe.names()
        described, values = probe.describe(*names), probe.values(*names)

    for descriptor, value in zip(described, values, strict=True):
        low, high = slider_positions(descriptor)
        assert -(2**31) <= low <= high < 2**31, descriptor.name
        assert descriptor.type == value.type, descriptor.name
    assert sum(bool(d.floating_point_range or d.integer_range) for d in described) > 15


def test_a_range_that_fits_no_slider_is_given_in_the_description(scripted):
    _, probe = scripted(
        integer("Throughput", 0, 2**32),
        integer("Offset", -(2**63), 2**63 - 1, 0),
        integer("Width", -(2**31), 2**31 - 1, 8),
        number("Fixed", 2.5, 2.5),
        number("Endless", -INFINITE, INFINITE, 0.0),
        number("Widest", -1.7e308, 1.7e308, 0.0),
        number("Epoch", 1e12, 1e12 + 1),
        number("Gain", -6.0, 24.0),
    )

    described = {
        d.name: d
        for d in probe.describe(
            "Throughput", "Offset", "Width", "Fixed", "Endless", "Widest", "Epoch", "Gain"
        )
    }

    ranged = {name for name, d in described.items() if d.integer_range or d.floating_point_range}
    assert ranged == {"Width", "Gain"}
    assert described["Throughput"].additional_constraints == "0 … 4294967296"


def test_what_cannot_be_read_has_no_type(scripted):
    """Given one, rqt_reconfigure makes an editor of it, fails at its value, and shows no more of the node."""
    hidden = replace(number("Ratio", 0.0, 4.0), value=None, access=AccessMode.NOT_AVAILABLE)
    _, probe = scripted(hidden)

    (descriptor,) = probe.describe("Ratio")

    assert (descriptor.type, probe.types("Ratio"), descriptor.read_only) == (0, [0], True)
    assert "not available" in descriptor.additional_constraints


def test_entries_are_in_the_description_which_is_all_that_is_shown(scripted):
    auto = Feature(
        name="GainAuto",
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_WRITE,
        value="Off",
        entries=(EnumEntry("Off"), EnumEntry("Once")),
    )
    _, probe = scripted(auto)

    assert probe.describe("GainAuto")[0].description == "GainAuto; one of Off, Once"


def test_vanished_parameters_are_reported_as_deleted_and_returned_ones_as_changed(scripted, events_of):
    """A change to no value at all ends rqt_reconfigure."""
    grabber, probe = scripted(integer("Marker", 0, 9), number("Ratio", 0.0, 4.0))
    events = events_of(probe, grabber)

    for access, value, reported in (
        (AccessMode.NOT_AVAILABLE, None, ("deleted", None)),
        (AccessMode.READ_WRITE, 2.0, ("changed", 2.0)),
    ):
        grabber.known["Ratio"] = replace(grabber.known["Ratio"], value=value, access=access)
        grabber.features_changed.emit(frozenset(["Ratio"]))
        assert reported_of(events, "Ratio") == reported


@pytest.mark.parametrize(
    "feature", [integer("Big", 0, 2**63 - 1), number("Big", -INFINITE, INFINITE, 0.0)], ids=["int", "float"]
)
def test_a_number_that_ends_viewers_is_not_reported(scripted, events_of, feature):
    grabber, probe = scripted(integer("Marker", 0, 9), feature)
    events = events_of(probe, grabber)

    grabber.set("Big", 2**40 if feature.kind is FeatureKind.INTEGER else INFINITE)
    grabber.set("Marker", 9)  # reported after it
    while reported_of(events, "Marker")[1] != 9:
        pass
    grabber.set("Big", 7)

    assert reported_of(events, "Big") == ("changed", 7)
    assert parameter_value_to_python(probe.values("Big")[0]) == 7


def test_refused_parameters_are_reported_with_their_value(scripted, events_of):
    """Viewers go on showing what they asked for, unless an event says otherwise."""
    grabber, probe = scripted(integer("Marker", 0, 9), number("Gain", 0.0, 24.0, 6.0))
    events = events_of(probe, grabber)

    assert not probe.set(Gain=99.0)[0].successful

    assert reported_of(events, "Gain") == ("changed", 6.0)


@pytest.fixture
def locked(scripted):
    serial = Feature(name="Serial", kind=FeatureKind.STRING, access=AccessMode.READ_ONLY, value="1.0")
    hidden = replace(number("Ratio", 0.0, 4.0), value=None, access=AccessMode.NOT_AVAILABLE)
    return scripted(serial, hidden, number("Gain", 0.0, 24.0, 6.0))


def test_a_dump_can_be_loaded_again(locked, tmp_path):
    grabber, probe = locked
    file = tmp_path / "dump.yaml"
    file.write_text("/scripted:\n  ros__parameters:\n    Gain: 7.0\n    Ratio: null\n    Serial: '1.0'\n")

    gain, ratio, serial = probe.load(file)

    assert gain.successful and grabber.known["Gain"].value == 7
    assert serial.successful, "it has that value already"
    assert not ratio.successful and "Ratio is not available" in ratio.reason


def test_a_dump_serves_as_the_parameter_file_without_a_warning(domain, tmp_path, caplog):
    file = tmp_path / "dump.yaml"
    file.write_text("/scripted:\n  ros__parameters:\n    Gain: 7.0\n    Ratio: null\n    Serial: '1.0'\n")
    serial = Feature(name="Serial", kind=FeatureKind.STRING, access=AccessMode.READ_ONLY, value="1.0")
    hidden = replace(number("Ratio", 0.0, 4.0), value=None, access=AccessMode.NOT_AVAILABLE)
    grabber = ScriptedGrabber([serial, hidden, number("Gain", 0.0, 24.0, 6.0)])

    with Ros2GrabberServer(grabber, "/scripted", ros_args=["--params-file", str(file)]):
        assert grabber.known["Gain"].value == 7

    assert not [record for record in caplog.records if "parameter file" in record.message]


def test_parameters_of_the_camera_cannot_be_deleted(locked):
    grabber, probe = locked

    refused = probe.set_message(Parameter(name="Gain"))

    assert not refused.successful and "cannot be deleted" in refused.reason
    assert grabber.known["Gain"].value == 6
