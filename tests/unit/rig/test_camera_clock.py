"""Clocks under PTP: state, offset and grandmaster are watched, and cameras of two masters share no clock."""

from __future__ import annotations

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.rig.camera_clock import CameraClock, network_clock, with_conflicts

HOURS = 3_600_000_000_000
"Of the cameras' clocks, which begin somewhere."


def clock_of(status: str, *, grandmaster: int = 0, offset: int = 250, enabled: bool = True) -> CameraClock:
    """Return a clock that was read once, of a camera whose PTP is in this state."""

    def feature(name: str, kind: FeatureKind, value: object) -> Feature:
        return Feature(name=name, kind=kind, value=value, access=AccessMode.READ_WRITE)  # type: ignore[arg-type]

    grabber = ScriptedGrabber(
        [
            feature("PtpEnable", FeatureKind.BOOLEAN, enabled),
            feature("PtpDataSetLatch", FeatureKind.COMMAND, None),
            feature("PtpStatus", FeatureKind.STRING, status),
            feature("PtpOffsetFromMaster", FeatureKind.INTEGER, offset),
            feature("PtpGrandmasterClockID", FeatureKind.INTEGER, grandmaster),
            feature("TimestampLatch", FeatureKind.COMMAND, None),
            feature("TimestampLatchValue", FeatureKind.INTEGER, HOURS),
        ]
    )
    clock = CameraClock(grabber, wanted="auto")
    clock.read()
    return clock


def test_state_offset_and_grandmaster_are_reported() -> None:
    state = clock_of("Slave", grandmaster=0x1122).state
    assert (state.kind, state.ptp_status, state.ptp_offset_ns) == ("ptp", "Slave", 250)
    assert state.grandmaster == "0000000000001122" and not state.problem
    assert "grandmaster 0000000000001122, +0.2 µs from its master" in str(state)


@pytest.mark.parametrize("status", ["Listening", "Uncalibrated", "Faulty", "PreMaster"])
def test_a_camera_that_is_not_locked_is_named(status: str) -> None:
    clock = clock_of(status)
    assert not clock.follows_ptp
    assert clock.state.problem == f"not locked to a master (PtpStatus {status})"
    assert network_clock([clock_of("Slave"), clock]) is None


def test_ptp_that_is_off_is_no_problem_unless_it_is_wanted() -> None:
    assert not clock_of("Disabled", enabled=False).state.problem


@pytest.mark.parametrize(
    ("second", "shared"),
    [
        (clock_of("Slave", grandmaster=0x1122), True),
        (clock_of("Slave"), True),
        (clock_of("Slave", grandmaster=0x3344), False),
        (clock_of("Master"), True),
    ],
)
def test_cameras_share_a_clock_if_they_have_one_grandmaster(second: CameraClock, shared: bool) -> None:
    clocks = {"left": clock_of("Slave", grandmaster=0x1122), "right": second}
    assert (network_clock(clocks.values()) is not None) is shared
    states = with_conflicts({name: clock.state for name, clock in clocks.items()})
    assert not states["left"].problem and bool(states["right"].problem) is not shared


def test_cameras_that_are_all_masters_do_not_hear_each_other() -> None:
    clocks = {name: clock_of("Master") for name in ("left", "right", "top")}
    assert network_clock(clocks.values()) is None
    states = with_conflicts({name: clock.state for name, clock in clocks.items()})
    problems = {name: state.problem for name, state in states.items()}
    wrong = "it follows another PTP master than left"
    assert problems == {"left": "", "right": wrong, "top": wrong}
