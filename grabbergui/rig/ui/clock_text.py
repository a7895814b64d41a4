"""A camera's clock in the user's words: what it follows, how exact it is, and what is wrong with it."""

from __future__ import annotations

from grabbergui.models.language import driver_text, localized, translate
from grabbergui.rig.camera_clock import ClockState


def clock_text(state: ClockState) -> str:
    """Return what is known of a clock, as `str(state)` does in English."""
    parts = [_kind(state.kind)]
    if state.ptp_status:
        parts.append(state.ptp_status)  # the feature's own word
    if state.grandmaster:
        parts.append(translate("Rig", "grandmaster {0}").format(state.grandmaster))
    if state.ptp_offset_ns is not None:
        offset = f"{state.ptp_offset_ns / 1000:+.1f}"
        parts.append(translate("Rig", "{0} µs from its master").format(offset))
    if state.uncertainty_ns is not None:
        parts.append(f"± {state.uncertainty_ns / 1000:.0f} µs")
    if state.drift_ppm is not None:
        parts.append(f"{state.drift_ppm:+.2f} ppm")
    text = localized(", ".join(parts))
    return f"{text}, {driver_text(state.problem)}" if state.problem else text


def _kind(kind: str) -> str:
    if kind == "ptp":
        return "PTP"
    if kind == "fitted":
        return translate("Rig", "fitted to the host's")
    return translate("Rig", "times of arrival")
