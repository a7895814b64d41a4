"""Why a triggered camera sends other frames than its triggers ask for, as display text. No I/O.

The evidence is what a camera and its host can know: edges on the line and missed triggers from events, the
level of the line, the frames that arrived, the triggers that we sent, and the settings. Times are nanoseconds
of one clock.
"""

from __future__ import annotations

import bisect
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

BOUNCE_NS = 1_000_000
"Edges that follow each other within this are one contact that bounces."
DOUBLE_PART = 0.35
"Part of the usual distance between pulses, below which a second pulse is a double one."
GAP = 1.5
"Distances of more than this many usual ones have pulses missing between them."
NEAR = 0.2
"Part of the usual distance by which a pulse of a regular signal may differ from its time."
LONGEST_GAP = 10
"Usual distances; a longer one is a pause of the sender."
REGULAR = 0.8
"Part of the distances that must be the usual one, or gaps between them are no missing pulses."
EDGE_NS = 50_000
"Time between a trigger that is sent and its edge on the line that cables and inputs may take."
AT_THE_LIMIT = 0.995
"Part of the shortest period that a camera follows in spite of the jitter of its clock."


class TriggerCause(Enum):
    """The cause of a trigger's problem."""

    NONE = "all is well"
    NO_SIGNAL = "no signal on the line"
    WRONG_EDGE = "wrong edge"
    TOO_FAST = "too fast for exposure and readout"
    BURST_NOT_FULL = "burst not full"
    ACTION_KEYS = "action key or mask wrong"
    ACTION_LOST = "action lost"
    DOUBLE = "double pulses"
    BOUNCING = "bouncing pulses"
    PULSES_MISSING = "pulses missing"
    FRAME_LOST = "frame lost on the wire"


@dataclass(frozen=True)
class ActionKeys:
    """Device key, group key and group mask of an action, or those that a camera accepts."""

    device_key: int
    group_key: int
    group_mask: int

    def refused_because(self, accepted: ActionKeys) -> str:
        """Return why a camera with the keys `accepted` ignores this action; empty if it does not."""
        if self.device_key != accepted.device_key:
            return f"ActionDeviceKey is {accepted.device_key}, the action has {self.device_key}"
        if self.group_key != accepted.group_key:
            return f"ActionGroupKey is {accepted.group_key}, the action has {self.group_key}"
        if not self.group_mask & accepted.group_mask:
            return (
                f"ActionGroupMask {accepted.group_mask:#x} and the action's {self.group_mask:#x} share no bit"
            )
        return ""


@dataclass(frozen=True)
class TriggerEvidence:
    """Observations of a camera under a trigger, over some time."""

    source: str
    "TriggerSource: `Line1`, `Software`, `Action1`."
    frames: tuple[int, ...] = ()
    "Starts of the exposures of the frames that arrived."
    lost: int = 0
    "Frames that were exposed but did not arrive complete: gaps of frame ids, incomplete frames."
    activation: str = "RisingEdge"
    rising: tuple[int, ...] | None = None
    "Rising edges on the line; None if the camera does not report them."
    falling: tuple[int, ...] | None = None
    level: bool | None = None
    "LineStatus; None if the camera has none."
    sent: tuple[int, ...] = ()
    "Triggers that we, or the leading camera, sent."
    sent_lost: int = 0
    "Exposures of the leading camera that are not in `sent`, because their frames were lost."
    clock_ns: int = 0
    "How far the clock of what was sent may be from the camera's."
    missed: tuple[int, ...] = ()
    "FrameTriggerMissed events."
    exposure_ns: int = 0
    readout_ns: int = 0
    overlapping: bool = True
    "Whether a frame may be exposed while the one before is read out; rolling shutters often may not."
    burst_frames: int = 1
    "Frames for each trigger."
    frame_start_waits: bool = False
    "Whether the frames of a burst wait for a trigger of their own."
    action: ActionKeys | None = None
    "The keys of the actions that were sent."
    accepted: ActionKeys | None = None
    "The keys of the actions that the camera accepts."
    acknowledged: int | None = None
    "How many of the actions were acknowledged; None if no acknowledge was asked for."
    rate: float = 0.0
    "The rate of the triggers in Hz, if it is known; else the usual distance between them counts."

    @property
    def shortest_period_ns(self) -> int:
        """The shortest time between triggers that the camera can follow."""
        if self.overlapping:
            return max(self.exposure_ns, self.readout_ns)
        return self.exposure_ns + self.readout_ns


@dataclass(frozen=True)
class TriggerFinding:
    """A cause, and a sentence for the user; the sentence is empty if all is well."""

    cause: TriggerCause
    sentence: str = ""


WELL = TriggerFinding(TriggerCause.NONE)


def diagnose(evidence: TriggerEvidence) -> TriggerFinding:
    """Return the one cause that explains the evidence best."""
    if evidence.source.startswith("Action") and (found := _of_actions(evidence)):
        return found
    on_line = evidence.source.startswith("Line")
    if on_line and (found := _of_edges(evidence)):
        return found
    pulses = list((_triggering(evidence) if on_line else None) or evidence.sent)
    if found := _of_pulses(evidence, pulses):
        return found
    if evidence.lost:
        return TriggerFinding(
            TriggerCause.FRAME_LOST,
            f"frames that were lost on the wire: {evidence.lost}; every trigger was taken: plan the link's"
            " budget",
        )
    return WELL


def _of_actions(evidence: TriggerEvidence) -> TriggerFinding | None:
    action, accepted = evidence.action, evidence.accepted
    if action is not None and accepted is not None and (why := action.refused_because(accepted)):
        return TriggerFinding(TriggerCause.ACTION_KEYS, f"the camera ignores the actions: {why}")
    sent, answers = len(evidence.sent), evidence.acknowledged
    if answers is None:
        return None
    # An action whose acknowledge was lost or late has made an exposure nevertheless.
    missing = sent - max(answers, len(evidence.frames) + evidence.lost + len(evidence.missed))
    if missing <= 0:
        return None
    return TriggerFinding(
        TriggerCause.ACTION_LOST,
        f"actions that did not reach the camera: {missing} of {sent}; they were lost on the network",
    )


def _of_edges(evidence: TriggerEvidence) -> TriggerFinding | None:
    rising, falling = evidence.rising, evidence.falling
    line = evidence.source
    if rising is None or falling is None:
        if not evidence.frames and not evidence.missed:
            state = {None: "", True: "; it is high", False: "; it is low"}[evidence.level]
            return TriggerFinding(TriggerCause.NO_SIGNAL, f"no trigger arrives on {line}{state}")
        return None
    if not rising and not falling:
        state = {None: "", True: ", it is always high", False: ", it is always low"}[evidence.level]
        return TriggerFinding(
            TriggerCause.NO_SIGNAL,
            f"there is no edge on {line}{state}: check the cable, LineMode and the sender",
        )
    wanted, other = (rising, falling) if evidence.activation == "RisingEdge" else (falling, rising)
    opposite = "FallingEdge" if evidence.activation == "RisingEdge" else "RisingEdge"
    if evidence.activation in ("RisingEdge", "FallingEdge"):
        if not wanted:
            return _wrong_edge(f"{line} has only edges of the other kind", opposite)
        early = evidence.clock_ns
        begin, late = _delay(evidence.sent, other, early), _delay(evidence.sent, wanted, early)
        if evidence.sent and begin + EDGE_NS + early < late:
            late = (late - begin) / 1000
            return _wrong_edge(f"the camera triggers at the end of each pulse, {late:.0f} µs late", opposite)
    return None


def _wrong_edge(what: str, opposite: str) -> TriggerFinding:
    return TriggerFinding(
        TriggerCause.WRONG_EDGE, f"{what}; set TriggerActivation to {opposite}, or switch LineInverter"
    )


def _delay(sent: Sequence[int], edges: Sequence[int], early: int) -> float:
    """Return the usual time from what was sent to its edge, in ns; infinite if there is none.

    An edge may seem to be `early`, as clocks differ.
    """
    delays = []
    for time in sent:
        at = bisect.bisect_left(edges, time - early)
        if at < len(edges):
            delays.append(max(0, edges[at] - time))
    return statistics.median(delays) if delays else float("inf")


def _triggering(evidence: TriggerEvidence) -> tuple[int, ...] | None:
    """Return the edges that trigger; None if they are not reported."""
    if evidence.rising is None or evidence.falling is None:
        return None
    if evidence.activation == "AnyEdge":
        return tuple(sorted((*evidence.rising, *evidence.falling)))
    return evidence.falling if evidence.activation in ("FallingEdge", "LevelLow") else evidence.rising


def _of_pulses(evidence: TriggerEvidence, pulses: list[int]) -> TriggerFinding | None:
    if not pulses:
        return _too_fast(evidence, sorted((*evidence.frames, *evidence.missed))) if evidence.missed else None
    usual = _usual_distance(evidence, pulses)
    on_line = evidence.source.startswith("Line")  # our own triggers are what they are
    if on_line and evidence.activation != "AnyEdge" and (found := _too_many(evidence, pulses, usual)):
        return found
    if (found := _too_fast(evidence, pulses)) is not None:
        return found
    if (found := _burst(evidence, pulses)) is not None:
        return found
    if not on_line:
        return None
    missing = _absent(evidence, pulses, usual) - evidence.lost
    if missing > 0:
        return TriggerFinding(
            TriggerCause.PULSES_MISSING,
            f"pulses missing between the others: {missing}; the sender or the cable drops some",
        )
    return None


def _too_many(evidence: TriggerEvidence, pulses: list[int], usual: float) -> TriggerFinding | None:
    """Name pulses that follow another too soon, unless the leading camera exposed so."""
    expected = _expected(evidence, pulses, usual)
    extra = set(pulses)
    for moment in expected or ():
        if (nearest := _nearest(moment, pulses)) is not None:
            extra.discard(nearest)
    close = []
    for index, (a, b) in enumerate(pairwise(pulses)):
        if b - a >= DOUBLE_PART * usual or not {a, b} & extra:
            continue
        after = pulses[index + 2] - a if index + 2 < len(pulses) else 0
        before = a - pulses[index - 1] if index else 0
        if b - a < BOUNCE_NS or _is_regular(after, usual) or _is_regular(before, usual):
            close.append(b - a)
    if len(close) <= evidence.sent_lost:
        return None
    bounces = [distance for distance in close if distance < BOUNCE_NS]
    if bounces:
        longest = max(bounces) / 1000
        return TriggerFinding(
            TriggerCause.BOUNCING,
            f"edges within {longest:.0f} µs of another: {len(bounces)}; a contact bounces: use a debouncer"
            " (LineDebouncerTime) or a clean signal",
        )
    if close:
        return TriggerFinding(
            TriggerCause.DOUBLE,
            f"double pulses, {statistics.median(close) / 1e6:.1f} ms apart: {len(close)}; are there two"
            " senders on the line?",
        )
    return None


def _absent(evidence: TriggerEvidence, pulses: list[int], usual: float) -> int:
    """Return how many pulses are missing between the others.

    If a leading camera sends them, its exposures tell: it may leave frames out itself. Otherwise only gaps in
    a regular signal do. A pulse that made a frame was there, though its event was lost.
    """
    expected = _expected(evidence, pulses, usual)
    if expected is None:
        distances = [b - a for a, b in pairwise(pulses)]
        if sum(_is_regular(each, usual, 1) for each in distances) < REGULAR * len(distances):
            return 0
        expected = []
        for a, distance in zip(pulses[:-1], distances, strict=True):
            if distance > GAP * usual and _is_regular(distance, usual, LONGEST_GAP):
                count = round(distance / usual)
                expected += [a + number * distance / count for number in range(1, count)]
    reach = NEAR * usual + evidence.clock_ns
    seen = sorted((*pulses, *evidence.frames))
    within = [moment for moment in expected if pulses[0] < moment < pulses[-1]]
    return sum(abs((_nearest(moment, seen) or 0) - moment) > reach for moment in within)


def _expected(evidence: TriggerEvidence, pulses: list[int], usual: float) -> list[float] | None:
    """Return when the pulses that were sent should have arrived; None if nobody knows."""
    if len(evidence.sent) < 2 or evidence.clock_ns > NEAR * usual:
        return None
    delay = _delay(evidence.sent, pulses, evidence.clock_ns)
    return [moment + delay for moment in evidence.sent]


def _nearest(moment: float, times: Sequence[int]) -> int | None:
    at = bisect.bisect_left(times, moment)
    return min(times[max(0, at - 1) : at + 1], key=lambda each: abs(each - moment), default=None)


def _is_regular(distance: float, usual: float, most: float = float("inf")) -> bool:
    """Whether a distance is a multiple of the usual one, at most `most` times it."""
    times = round(distance / usual) if usual else 0
    return 1 <= times <= most and abs(distance - times * usual) <= NEAR * usual


def _usual_distance(evidence: TriggerEvidence, pulses: Sequence[int]) -> float:
    if evidence.rate > 0:
        return 1e9 / evidence.rate
    distances = [b - a for a, b in pairwise(pulses)]
    if evidence.source.startswith("Line") and len(evidence.sent) > 2:
        distances = [b - a for a, b in pairwise(evidence.sent)]
    distances = [distance for distance in distances if distance >= BOUNCE_NS / 2] or distances
    if not distances:
        return 0.0
    # With double pulses short and long distances alternate; the long ones are the usual ones.
    longer = sorted(distances)[len(distances) // 2 :]
    return float(statistics.median(longer))


def _too_fast(evidence: TriggerEvidence, pulses: Sequence[int]) -> TriggerFinding | None:
    needed = evidence.shortest_period_ns * evidence.burst_frames
    distances = [b - a for a, b in pairwise(pulses)]
    if not evidence.missed or not needed or not distances:
        return None
    usual = statistics.median(distances)
    if usual >= AT_THE_LIMIT * needed:
        return None
    highest = 1e9 / needed
    sentence = (
        f"triggers come at {1e9 / usual:.1f} Hz, but exposure and readout allow {highest:.1f} Hz;"
        f" {len(evidence.missed)} were missed"
    )
    if not evidence.overlapping:
        with_overlap = 1e9 / (max(evidence.exposure_ns, evidence.readout_ns) * evidence.burst_frames)
        sentence += f" (without overlap of exposure and readout; with it {with_overlap:.1f} Hz)"
    if evidence.burst_frames > 1:
        sentence += f", with {evidence.burst_frames} frames for each trigger"
    return TriggerFinding(TriggerCause.TOO_FAST, sentence)


def _burst(evidence: TriggerEvidence, pulses: Sequence[int]) -> TriggerFinding | None:
    wanted = evidence.burst_frames
    if wanted < 2:
        return None
    exposed = len(evidence.frames) + evidence.lost
    # The last burst may not have ended yet.
    if exposed >= (len(pulses) - 1) * wanted:
        return None
    each = exposed / len(pulses)
    why = (
        "each frame waits for a trigger of its own: set TriggerMode[TriggerSelector=FrameStart] to Off"
        if evidence.frame_start_waits
        else "the acquisition ends before: check AcquisitionMode and AcquisitionFrameCount"
    )
    return TriggerFinding(
        TriggerCause.BURST_NOT_FULL, f"a trigger makes {each:.1f} frames instead of {wanted}; {why}"
    )
