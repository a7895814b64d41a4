"""The clocks of a rig's cameras in the window: in English as on the command line, and in another language."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grabbergui.models.language import set_translator
from grabbergui.rig.camera_clock import ClockState
from grabbergui.rig.ui.clock_text import clock_text

STATES = [
    ClockState("host"),
    ClockState("fitted", uncertainty_ns=12_000, drift_ppm=-3.25),
    ClockState(
        "ptp", uncertainty_ns=2_000, ptp_status="Slave", ptp_offset_ns=1_500, grandmaster="00112233445566FF"
    ),
    ClockState("host", ptp_status="Listening", problem="not locked to a master (PtpStatus Listening)"),
    ClockState("host", problem="PTP is off"),
    ClockState("ptp", problem="it follows another PTP master A1 than left"),
]


@pytest.fixture
def foreign() -> Iterator[None]:
    """A language in which every text that is translated stands in brackets."""
    set_translator(lambda context, text: f"[{text}]", ",")
    yield
    set_translator(None)


@pytest.mark.parametrize("state", STATES, ids=str)
def test_it_is_the_same_in_english(state: ClockState) -> None:
    assert clock_text(state) == str(state)


@pytest.mark.usefixtures("foreign")
@pytest.mark.parametrize(
    ("state", "text"),
    [
        (STATES[0], "[times of arrival]"),
        (STATES[1], "[fitted to the host's], ± 12 µs, -3,25 ppm"),
        (STATES[2], "PTP, Slave, [grandmaster 00112233445566FF], [+1,5 µs from its master], ± 2 µs"),
        (STATES[3], "[times of arrival], Listening, [not locked to a master (PtpStatus Listening)]"),
        (STATES[4], "[times of arrival], [PTP is off]"),
        (STATES[5], "PTP, [it follows another PTP master A1 than left]"),
    ],
)
def test_every_word_of_ours_is_translated(state: ClockState, text: str) -> None:
    assert clock_text(state) == text
