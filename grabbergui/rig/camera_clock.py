"""The clocks of a rig's cameras: read, fitted to the host's, or kept equal by PTP, and watched.

`CameraClock` makes stamps of frames, on any thread. `ClockWatch` reads the clocks on a thread of its own.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.rig.clock_fit import ClockEstimate, ClockFit, HostTime
from grabbergui.rig.frame_sets import FrameStamp

log = logging.getLogger(__name__)

LATCHES = (
    ("TimestampLatch", "TimestampLatchValue", ""),
    ("GevTimestampControlLatch", "GevTimestampValue", "GevTimestampTickFrequency"),
)
"Command, value, and the value's frequency; empty for nanoseconds."
READ_PERIOD = 1.0
"Seconds between readings of a clock; the first few follow each other at once."
FIRST_READINGS = 4
LONGEST_TRANSIT_NS = 5_000_000_000
"A frame that is older when it arrives has a wrong time."
PTP_SWITCHES = ("PtpEnable", "GevIEEE1588")
PTP_SETTLED = ("Slave", "Master")
PTP_UNCERTAINTY_NS = 1_000
"Added to the offset from its master that a camera reports."


@dataclass(frozen=True)
class ClockState:
    """The state of a camera's clock."""

    kind: str
    "`ptp`, `fitted`, or `host`: times of arrival."
    uncertainty_ns: int | None = None
    "Uncertainty of its time on the host's clock; None if unknown."
    drift_ppm: float | None = None
    "Against the host's clock."
    ptp_status: str = ""
    ptp_offset_ns: int | None = None
    "From its master."
    grandmaster: str = ""
    problem: str = ""
    "Why it is not as wanted, as display text."

    def __str__(self) -> str:
        parts = [{"ptp": "PTP", "fitted": "fitted to the host's", "host": "times of arrival"}[self.kind]]
        if self.ptp_status:
            parts.append(f"{self.ptp_status}")
        if self.grandmaster:
            parts.append(f"grandmaster {self.grandmaster}")
        if self.ptp_offset_ns is not None:
            parts.append(f"{self.ptp_offset_ns / 1000:+.1f} µs from its master")
        if self.uncertainty_ns is not None:
            parts.append(f"± {self.uncertainty_ns / 1000:.0f} µs")
        if self.drift_ppm is not None:
            parts.append(f"{self.drift_ppm:+.2f} ppm")
        if self.problem:
            parts.append(self.problem)
        return ", ".join(parts)


class CameraClock:
    """The clock of one camera: readings and arrivals in, stamps out. Any thread."""

    def __init__(self, grabber: FrameGrabber, *, wanted: str) -> None:
        """`wanted` is `auto`, `ptp`, `fitted` or `host`; PTP must have been switched on."""
        self._grabber = grabber
        self._wanted = wanted
        self._lock = threading.Lock()
        self._fit = ClockFit()
        self._estimate: ClockEstimate | None = None
        self._arrivals = 0
        self._latch = next((latch for latch in LATCHES if grabber.has_feature(latch[0])), None)
        self.state = ClockState("host")

    @property
    def follows_ptp(self) -> bool:
        """Whether the camera's clock is that of the network."""
        return self.state.kind == "ptp"

    def read(self) -> None:
        """Read the camera's clock and PTP state. Raises GrabberError."""
        ptp = self._read_ptp() if self._wanted in ("auto", "ptp") else None
        if self._wanted != "host":
            self._read_clock()
        with self._lock:
            self._estimate = estimate = self._fit.estimate()
        state = ptp or ClockState("host")
        if estimate is not None:
            newest = estimate.host_time(estimate.newest_ns)
            state = replace(
                state,
                kind=state.kind if state.kind == "ptp" else "fitted",
                uncertainty_ns=newest.uncertainty_ns,
                drift_ppm=estimate.drift * 1e6,
            )
        self.state = state

    def stamp(self, frame: Frame, shared: ClockEstimate | None = None) -> FrameStamp:
        """Return the moment of a frame on the host's monotonic clock.

        `shared` maps the clock of the network if all cameras are under PTP; then only what PTP leaves is
        uncertain between them. A frame whose camera's clock is not known has the time of its arrival, without
        an uncertainty. One that its clock dates after its arrival, or long before, shows that the clock was
        set since it was read: its time is uncertain.
        """
        arrival = FrameStamp(round(frame.captured * 1e9), 0, frame.frame_id)
        if not frame.timestamp_ns or self._wanted == "host":
            return arrival
        if shared is not None:
            uncertainty = abs(self.state.ptp_offset_ns or 0) + PTP_UNCERTAINTY_NS
            return _believable(shared.host_time(frame.timestamp_ns), uncertainty, arrival)
        with self._lock:
            if self._latch is None:
                self._add_arrival(frame)
            estimate = self._estimate
        if estimate is None:
            return arrival
        found = estimate.host_time(frame.timestamp_ns)
        return _believable(found, found.uncertainty_ns, arrival)

    @property
    def estimate(self) -> ClockEstimate | None:
        """The fitted clock; None if nothing bounds it."""
        return self._estimate

    def forget(self) -> None:
        """Drop what is known, as after the camera was lost."""
        with self._lock:
            self._fit.forget()
            self._estimate = None

    def _add_arrival(self, frame: Frame) -> None:
        self._fit.add_arrival(frame.timestamp_ns, round(frame.captured * 1e9))
        self._arrivals += 1
        if self._arrivals % 32 == 0:
            self._estimate = self._fit.estimate()

    def _read_clock(self) -> None:
        if self._latch is None:
            return
        command, value, frequency = self._latch
        with self._grabber.exclusive():
            before = time.monotonic_ns()
            self._grabber.execute(command)
            after = time.monotonic_ns()
            ticks = self._grabber.feature(value).value
        if not isinstance(ticks, int):
            return
        if frequency:
            hertz = self._grabber.feature(frequency).value
            if not isinstance(hertz, int) or hertz <= 0:
                return
            ticks = ticks * 1_000_000_000 // hertz
        with self._lock:
            self._fit.add_reading(ticks, before, after)

    def _read_ptp(self) -> ClockState | None:
        """Return the state of PTP; None if the camera has it not, or need not have it."""
        grabber = self._grabber
        name = ptp_switch(grabber)
        if name is None or not grabber.feature(name).value:
            if self._wanted == "ptp":
                return ClockState("host", problem="it has no PTP" if name is None else "PTP is off")
            return None
        if grabber.has_feature("PtpDataSetLatch"):
            grabber.execute("PtpDataSetLatch")
        status = self._text("PtpStatus") or self._text("GevIEEE1588Status")
        offset = self._value("PtpOffsetFromMaster")
        grandmaster = self._text("PtpGrandmasterClockID")
        if not grandmaster.strip("0"):  # it knows none yet
            grandmaster = ""
        settled = status in PTP_SETTLED
        problem = "" if settled else f"not locked to a master (PtpStatus {status or 'unknown'})"
        return ClockState(
            "ptp" if settled else "host",
            ptp_status=status,
            ptp_offset_ns=offset if settled else None,
            grandmaster=grandmaster,
            problem=problem,
        )

    def _value(self, name: str) -> int | None:
        value = self._grabber.feature(name).value if self._grabber.has_feature(name) else None
        return value if isinstance(value, int) else None

    def _text(self, name: str) -> str:
        value = self._grabber.feature(name).value if self._grabber.has_feature(name) else None
        if isinstance(value, int) and not isinstance(value, bool):
            return f"{value:016X}"
        return "" if value is None else str(value)


def _believable(found: HostTime, uncertainty_ns: int, arrival: FrameStamp) -> FrameStamp:
    latest = arrival.time_ns + found.uncertainty_ns
    if latest - LONGEST_TRANSIT_NS <= found.time_ns <= latest:
        return FrameStamp(found.time_ns, uncertainty_ns, arrival.counter)
    return FrameStamp(arrival.time_ns, LONGEST_TRANSIT_NS, arrival.counter)


def network_clock(clocks: Iterable[CameraClock]) -> ClockEstimate | None:
    """Return the clock of the network if all cameras follow it, as the first one shows it; else None."""
    clocks = tuple(clocks)
    states = [clock.state for clock in clocks]
    return clocks[0].estimate if all(clock.follows_ptp for clock in clocks) and _one_master(states) else None


def _one_master(states: Iterable[ClockState]) -> bool:
    """Whether settled cameras can follow one master: two of them, or two grandmasters, are two clocks."""
    states = tuple(states)
    named = {state.grandmaster for state in states if state.grandmaster}
    return len(named) <= 1 and sum(state.ptp_status == "Master" for state in states) <= 1


def with_conflicts(states: Mapping[str, ClockState]) -> dict[str, ClockState]:
    """Return the states with a problem for each camera that follows another master than those before it."""
    found: dict[str, ClockState] = {}
    for name, state in states.items():
        others = {other: each for other, each in found.items() if each.kind == "ptp" and not each.problem}
        if state.kind == "ptp" and not state.problem and not _one_master([*others.values(), state]):
            first, master = next(iter(others)), state.grandmaster
            problem = f"it follows another PTP master than {first}"
            if master:
                problem = f"it follows another PTP master {master} than {first}"
            state = replace(state, problem=problem)
        found[name] = state
    return found


def ptp_switch(grabber: FrameGrabber) -> str | None:
    """Return the feature that switches PTP on; None if the camera has none."""
    return next((name for name in PTP_SWITCHES if grabber.has_feature(name)), None)


class ClockWatch:
    """Reads the clocks of all cameras now and then, on a thread of its own."""

    def __init__(self, clocks: Mapping[str, CameraClock], changed: Callable[[], object]) -> None:
        """`changed` is called after each round, on the thread."""
        self._clocks = dict(clocks)
        self._changed = changed
        self._problems: dict[str, str] = {}
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="rig clocks", daemon=True)

    def start(self) -> None:
        """Read every clock a few times, then go on reading on the thread."""
        for _ in range(FIRST_READINGS):
            self.read()
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it."""
        self._stopping.set()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def read(self) -> None:
        """Read every clock once."""
        for name, clock in self._clocks.items():
            try:
                clock.read()
                self._problems.pop(name, None)
            except GrabberError as error:  # it may be lost, and will be back
                if self._problems.get(name) != str(error):
                    self._problems[name] = str(error)
                    log.info("the clock of %s cannot be read: %s", name, error)
        self._changed()

    def _run(self) -> None:
        while not self._stopping.wait(READ_PERIOD):
            self.read()
