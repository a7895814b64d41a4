"""Health of a stream, and the diagnosis of a missing image."""

from dataclasses import replace

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.errors import TransportError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access
from grabbergui.core.sfnc import Role
from grabbergui.models import language
from grabbergui.models.diagnosis import (
    WINDOW,
    CameraFacts,
    Health,
    HealthMeter,
    Stage,
    StreamObservation,
    diagnose,
)
from grabbergui.rig.trigger_setup import TriggerSetup

BEFORE = {"frames": 100, "packets": 100_000}
BY_EXPOSURE = frozenset({Role.EXPOSURE})
NOW = {"frames": 200, "packets": 200_000}


def judged(before, after, meter=None):
    meter = meter or HealthMeter()
    meter.judge(0.0, StreamStatistics(**before))
    return meter.judge(1.0, StreamStatistics(**after))


@pytest.mark.parametrize(
    ("changes", "health", "text"),
    [
        ({}, Health.WHOLE, "0 lost · 0 incomplete"),
        ({"packets_resent": 5_000}, Health.RESENT, "0 lost · 0 incomplete · 5.0% resent"),
        ({"packets_resent": 3}, Health.WHOLE, "0 lost · 0 incomplete · 3 resent"),
        ({"incomplete": 1}, Health.LOSING, "0 lost · 1 incomplete"),
        ({"lost": 2, "underruns": 3}, Health.LOSING, "5 lost · 0 incomplete"),
        ({"overruns": 1, "incomplete": 9}, Health.OVERRUN, "more arrives than this computer can take"),
    ],
)
def test_health_depends_on_the_last_seconds(changes, health, text):
    found = judged(BEFORE, NOW | changes)
    assert (found.health, found.text) == (health, text)


def test_earlier_losses_are_counted_but_no_longer_coloured():
    meter, lost = HealthMeter(), NOW | {"lost": 2}
    assert judged(BEFORE, lost, meter).health is Health.LOSING
    later = meter.judge(1.5 + WINDOW, StreamStatistics(**lost))
    assert (later.health, later.text) == (Health.WHOLE, "2 lost · 0 incomplete")


def test_a_stream_that_begins_again_counts_from_nothing():
    meter = HealthMeter()
    judged(BEFORE, NOW | {"lost": 7}, meter)
    assert meter.judge(2.0, StreamStatistics(frames=1, packets=10)).health is Health.WHOLE


def test_every_counter_is_in_the_details():
    found = judged(BEFORE, NOW | {"lost": 1, "incomplete": 2, "underruns": 3, "packets_resent": 4,
                                  "packets_missing": 5, "overruns": 6})  # fmt: skip
    for words in ("200, lost 1, incomplete 2", "dropped because they were not taken in time: 3",
                  "resent 4, never arrived 5", "discarded: 6×"):  # fmt: skip
        assert words in found.detail


SILENT = StreamObservation(
    "Acme One", address="10.0.0.7", bus="GigE Vision", silent=5.0, statistics=StreamStatistics()
)
RUNNING = StreamObservation(
    "Acme One", silent=0.04, statistics=StreamStatistics(frames=900),
    mean=90.0,
)  # fmt: skip


def test_there_is_no_diagnosis_while_all_is_well_or_too_early():
    assert diagnose(RUNNING) is None
    assert diagnose(replace(SILENT, silent=0.5)) is None


def test_no_packets_names_firewall_port_address_and_the_command_that_opens_it():
    found = diagnose(replace(SILENT, facts=CameraFacts(stream_port=50010, packet_size=8192)))
    assert found.stage is Stage.PACKETS
    assert "UDP port 50010" in found.advice
    assert "sudo ufw allow proto udp from 10.0.0.7 to any port 50010" in found.advice
    assert "8192 bytes need an MTU as large" in found.advice


def test_a_remote_source_says_itself_what_is_silent():
    found = diagnose(replace(SILENT, bus="YARP", silence="/cam is connected over tcp and sends nothing"))
    assert found.stage is Stage.PACKETS
    assert found.summary == "/cam is connected over tcp and sends nothing."
    assert "waits for a trigger" in found.advice


def test_no_firewall_is_blamed_for_a_source_that_uses_none():
    found = diagnose(replace(SILENT, bus="USB3 Vision"))
    assert found.stage is Stage.PACKETS
    assert "irewall" not in found.advice


@pytest.mark.parametrize(
    ("statistics", "words"),
    [
        (StreamStatistics(packets=900, incomplete=4, packets_missing=70), ["70 packets", "1500 bytes"]),
        (StreamStatistics(packets=900), ["900 packets", "MTU"]),
        (StreamStatistics(packets=900, frames=12), ["after 12", "cable"]),
    ],
)
def test_packets_without_frames(statistics, words):
    found = diagnose(replace(SILENT, statistics=statistics, facts=CameraFacts(packet_size=1500)))
    assert found.stage is Stage.FRAMES
    assert all(word in found.summary + found.advice for word in words)


def test_waiting_for_a_trigger_is_no_fault():
    assert diagnose(replace(SILENT, facts=CameraFacts(triggers=(TriggerSetup("Line1"),)))) is None


def test_a_slow_camera_is_given_time():
    slow = replace(SILENT, facts=CameraFacts(period=2.0))
    assert diagnose(slow) is None
    assert diagnose(replace(slow, silent=7.0)) is not None


def test_a_format_that_cannot_be_converted():
    found = diagnose(replace(RUNNING, problem="pixel format 0x81080001 is unknown"))
    assert found.stage is Stage.CONVERSION
    assert "0x81080001" in found.summary


def test_a_black_image_is_blamed_on_the_exposure_with_its_value():
    found = diagnose(replace(RUNNING, mean=0.4, facts=CameraFacts(exposure="10 us")))
    assert found.stage is Stage.DISPLAY
    assert "exposure (10 us) may be too short" in found.summary


@pytest.mark.parametrize(
    ("features", "advice"),
    [
        (("ExposureTime", "Gain"), "Raise exposure or gain, or press E. Open"),
        (("Shutter",), "Raise the exposure, or press E. Open"),
        (("GainRaw",), "Raise the gain, or press E. Open"),
        ((), "Open the iris, or"),
    ],
)
def test_only_what_the_camera_can_do_is_advised_for_a_black_image(features, advice):
    grabber = ScriptedGrabber(
        [
            Feature(name=name, kind=FeatureKind.FLOAT, value=1.0, access=AccessMode.READ_WRITE)
            for name in features
        ]
    )
    found = diagnose(replace(RUNNING, mean=0.4, facts=CameraFacts.read(grabber)))
    assert found.advice.startswith(advice)
    grabber.open(Access.MONITOR)
    found = diagnose(replace(RUNNING, mean=0.4, facts=CameraFacts.read(grabber)))
    assert found.advice == "Open the iris, or take the lens cap off."


def test_a_black_recording_needs_no_lens_cap_taken_off():
    found = diagnose(replace(RUNNING, mean=0.4, facts=CameraFacts(playing=True)))
    assert (found.summary, found.advice) == ("The recorded image is black.", "")


def test_frames_that_are_not_painted():
    assert diagnose(replace(RUNNING, unpainted=1.0, mean=None)) is None, "the first may be on its way"
    assert diagnose(replace(RUNNING, unpainted=2.0, mean=None)).stage is Stage.DISPLAY


def test_facts_are_read_under_the_names_that_the_camera_has(monkeypatch):
    def feature(name, value, kind=FeatureKind.INTEGER, unit=""):
        return Feature(name=name, kind=kind, value=value, access=AccessMode.READ_WRITE, unit=unit)

    grabber = ScriptedGrabber(
        [
            feature("TriggerMode", "On", FeatureKind.ENUMERATION),
            feature("TriggerSource", "Line1", FeatureKind.ENUMERATION),
            feature("GevSCPHostPort", 50010),
            feature("GevSCPSPacketSize", 1400),
            feature("ExposureTimeAbs", 12.5, FeatureKind.FLOAT, "us"),
            feature("AcquisitionFrameRateAbs", 4.0, FeatureKind.FLOAT, "Hz"),
        ]
    )
    assert CameraFacts.read(grabber) == CameraFacts(
        (TriggerSetup("Line1"),), 50010, 1400, "12.5 µs", 0.25, brightened_by=BY_EXPOSURE
    )
    grabber.failures["TriggerSource"] = TransportError("no answer")
    assert CameraFacts.read(grabber).trigger_source == "an input"
    monkeypatch.setattr(language, "_translator", lambda context, text: f"<{text}>")
    assert CameraFacts.read(grabber).trigger_source == "<an input>"
    assert CameraFacts.read(ScriptedGrabber()) == CameraFacts()
