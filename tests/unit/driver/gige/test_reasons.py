"""One diagnosis of a camera that sends nothing: firewall, NAT, two cards, an unknown payload."""

from __future__ import annotations

from dataclasses import replace

import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.doctor import gige
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.reasons import FIREWALL, StreamFacts, no_frames, not_found
from grabbergui.models.diagnosis import Stage, StreamObservation, diagnose

CARD = Interface("eth1", "192.168.1.2")
TWIN = Interface("eth0", "192.168.1.3")
OTHER = Interface("eth2", "10.0.0.1")
NOTHING = StreamFacts(StreamStatistics(), "192.168.1.10", 40000, CARD)


def test_a_firewall_is_named_with_the_command_that_opens_it() -> None:
    reason = no_frames(NOTHING, [CARD, OTHER])
    assert "sudo ufw allow proto udp from 192.168.1.10 to any port 40000" in reason
    assert "MTU" in no_frames(replace(NOTHING, packet_size=9000), [CARD])


def test_address_translation_is_seen_by_the_cameras_register() -> None:
    reason = no_frames(replace(NOTHING, seen_as="10.9.9.9"), [CARD])
    assert "the camera sees this computer at 10.9.9.9, not at 192.168.1.2" in reason and "NAT" in reason
    assert "firewall" in no_frames(replace(NOTHING, seen_as="192.168.1.2"), [CARD])


def test_two_cards_in_one_subnet_are_named() -> None:
    reason = no_frames(NOTHING, [CARD, TWIN, OTHER])
    (finding,) = gige.shared_networks([CARD, TWIN, OTHER])
    assert finding.text in reason and finding.remedy in reason, "doctor says the same"
    assert finding.text in not_found([CARD, TWIN])


def test_an_unknown_payload_is_the_reason_and_not_the_cable() -> None:
    facts = replace(NOTHING, statistics=StreamStatistics(packets=9), fault="the camera sends audio")
    assert no_frames(facts, [CARD, TWIN]) == "the camera sends audio"
    assert no_frames(replace(facts, statistics=StreamStatistics(frames=1, packets=9)), [CARD]) == ""
    assert no_frames(replace(facts, fault=""), [CARD]) == "", "incomplete frames have reasons of their own"


def test_window_and_command_line_give_the_reason() -> None:
    reason = no_frames(replace(NOTHING, seen_as="10.9.9.9"), [CARD])
    seen = StreamObservation("a camera", "192.168.1.10", "GigE Vision", silent=9.0, silence=reason)
    found = diagnose(seen)
    assert found is not None and found.stage is Stage.PACKETS
    assert "sends nothing that arrives" in found.summary and reason in found.advice
    broken = diagnose(replace(seen, statistics=StreamStatistics(packets=9), silence="the camera sends audio"))
    assert broken is not None and broken.stage is Stage.FRAMES and "the camera sends audio" in broken.advice


def test_list_says_what_hides_cameras(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("grabbergui.driver.gige.interfaces.interfaces", lambda: [CARD])
    monkeypatch.setattr(sources, "discover", lambda timeout, longer: [])
    assert main(["list"]) == 0
    assert FIREWALL in capsys.readouterr().err
