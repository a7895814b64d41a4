"""Health of a stream, and the diagnosis of a missing image. Pure logic.

A diagnosis names the stage at which the image stops, and the likely cause.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import Enum

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.frame_period import frame_period
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.models.features.number_text import quantity_text
from grabbergui.models.language import counted, driver_text, localized, translate
from grabbergui.rig.trigger_setup import TriggerSetup, triggers_on

WINDOW = 5.0
"Seconds over which health is judged."
NOTABLE = 0.001
"Fraction of resent packets that is worth a colour: a few are lost on any network."
PATIENCE = 2.0
"Seconds without a frame before a diagnosis is shown."
BLACK = 2.0
"Mean of 8-bit pixels below which an image seems black."
_GIGE = "GigE"


class Health(Enum):
    """The quality of the stream in the last seconds."""

    WHOLE = "whole"
    RESENT = "resent"
    "Packets were lost, and arrived when they were requested again."
    LOSING = "losing"
    "Frames were lost or had packets missing."
    OVERRUN = "overrun"
    "More arrives than this computer can handle."


@dataclass(frozen=True)
class StreamHealth:
    """A stream's quality with its display texts."""

    health: Health = Health.WHOLE
    text: str = ""
    "A few words for the status strip."
    detail: str = ""
    "All counters since the start."


class HealthMeter:
    """Compares a stream's counters with those of some seconds ago. One thread."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, StreamStatistics]] = deque()

    def judge(self, now: float, statistics: StreamStatistics) -> StreamHealth:
        """Return the health at `now`, in seconds of any monotonic clock; call it several times a second."""
        if self._seen and _restarted(self._seen[-1][1], statistics):
            self._seen.clear()
        self._seen.append((now, statistics))
        while now - self._seen[0][0] > WINDOW:
            self._seen.popleft()
        before = self._seen[0][1]
        packets = statistics.packets - before.packets
        share = (statistics.packets_resent - before.packets_resent) / packets if packets > 0 else 0.0
        health = Health.WHOLE
        if statistics.overruns > before.overruns:
            health = Health.OVERRUN
        elif _gone(statistics) > _gone(before):
            health = Health.LOSING
        elif share >= NOTABLE:
            health = Health.RESENT
        return StreamHealth(health, _text(statistics, health, share), _detail(statistics))


def _gone(statistics: StreamStatistics) -> int:
    """Return the number of lost and incomplete frames."""
    return statistics.lost + statistics.incomplete + statistics.underruns


def _restarted(before: StreamStatistics, now: StreamStatistics) -> bool:
    return now.frames < before.frames or now.packets < before.packets or _gone(now) < _gone(before)


def _text(statistics: StreamStatistics, health: Health, share: float) -> str:
    if health is Health.OVERRUN:
        return translate("StreamHealth", "more arrives than this computer can take")
    lost = statistics.lost + statistics.underruns
    parts = [
        counted(lost, translate("StreamHealth", "1 lost"), translate("StreamHealth", "{0} lost")),
        counted(
            statistics.incomplete,
            translate("StreamHealth", "1 incomplete"),
            translate("StreamHealth", "{0} incomplete"),
        ),
    ]
    if share >= NOTABLE:
        parts.append(translate("StreamHealth", "{0:.1%} resent").format(share))
    elif statistics.packets_resent:
        parts.append(
            counted(
                statistics.packets_resent,
                translate("StreamHealth", "1 resent"),
                translate("StreamHealth", "{0} resent"),
            )
        )
    return localized(" · ".join(parts))


def _detail(statistics: StreamStatistics) -> str:
    lines = [
        translate("StreamHealth", "Frames since the start: {0}, lost {1}, incomplete {2}").format(
            statistics.frames, statistics.lost, statistics.incomplete
        )
    ]
    if statistics.underruns:
        text = translate("StreamHealth", "Frames dropped because they were not taken in time: {0}")
        lines.append(text.format(statistics.underruns))
    if statistics.packets:
        text = translate("StreamHealth", "Packets: {0}, resent {1}, never arrived {2}")
        lines.append(text.format(statistics.packets, statistics.packets_resent, statistics.packets_missing))
    if statistics.packets_foreign:
        text = translate("StreamHealth", "Packets refused, as they did not come from the camera: {0}")
        lines.append(text.format(statistics.packets_foreign))
    if statistics.overruns:
        text = translate(
            "StreamHealth",
            "All waiting packets discarded: {0}×; choose larger packets or a lower frame rate",
        )
        lines.append(text.format(statistics.overruns))
    return "\n".join(lines)


class Stage(Enum):
    """The stages that an image passes, in order."""

    CONTROL = "control"
    PACKETS = "packets"
    FRAMES = "frames"
    CONVERSION = "conversion"
    DISPLAY = "display"


@dataclass(frozen=True)
class CameraFacts:
    """The camera's features that matter for the diagnosis; None for those that it lacks."""

    triggers: tuple[TriggerSetup, ...] = ()
    "Those that are on, the first one waited for first."
    stream_port: int | None = None
    "The UDP port on this host that the camera sends to."
    packet_size: int | None = None
    "Bytes of a stream packet, IP and UDP headers included."
    exposure: str = ""
    "The exposure with its unit, as display text."
    period: float | None = None
    "Frame period in seconds by the camera's settings."
    playing: bool | None = None
    "Whether a recording plays; None for a camera."
    brightened_by: frozenset[Role] = frozenset()
    "Exposure and gain: those that the camera has and that may be changed from here."

    @property
    def trigger_source(self) -> str | None:
        """The trigger that the camera waits for, as display text; None if none is on."""
        if not self.triggers:
            return None
        return self.triggers[0].source or translate("Diagnosis", "an input")

    @classmethod
    def read(cls, grabber: FrameGrabber) -> CameraFacts:
        """Read the facts, omitting features that cannot be read. On the thread of the camera's calls."""
        exposure = _of_role(grabber, Role.EXPOSURE)
        playing = _value(grabber, "PlaybackActive")
        controlled = grabber.access is not Access.MONITOR
        return cls(
            triggers=triggers_on(grabber),
            stream_port=_integer(_value(grabber, "GevSCPHostPort")),
            packet_size=_integer(_value(grabber, "GevSCPSPacketSize")),
            exposure=quantity_text(exposure.value, exposure.unit)
            if exposure is not None and isinstance(exposure.value, (int, float))
            else "",
            period=frame_period(grabber) or None,
            playing=bool(playing) if playing is not None else None,
            brightened_by=frozenset(
                role for role in (Role.EXPOSURE, Role.GAIN) if controlled and grabber.role(role) is not None
            ),
        )


@dataclass(frozen=True)
class StreamObservation:
    """Observations of a streaming source in the window."""

    source: str
    "Its display name."
    address: str = ""
    "Its IP address, USB path or port."
    bus: str = ""
    unpainted: float = 0.0
    "Seconds for which frames have reached the window without any having been painted."
    silent: float = 0.0
    "Seconds since the last frame, or since the start."
    statistics: StreamStatistics = field(default_factory=StreamStatistics)
    problem: str = ""
    "Why frames cannot be converted."
    mean: float | None = None
    "Mean of the 8-bit pixels of the last painted frame."
    facts: CameraFacts = CameraFacts()
    silence: str = ""
    "Report of a remote source while no images arrive."


@dataclass(frozen=True)
class Diagnosis:
    """The stage at which frames stop, and the remedy; texts as display text."""

    stage: Stage
    summary: str
    advice: str


def diagnose(seen: StreamObservation) -> Diagnosis | None:
    """Return the fault; None if there is none or if it is too early to know."""
    if seen.problem:
        return Diagnosis(
            Stage.CONVERSION,
            translate("Diagnosis", "Frames arrive but cannot be shown: {0}").format(seen.problem),
            translate("Diagnosis", "Choose another PixelFormat; a snapshot still saves the raw bytes."),
        )
    patience = max(PATIENCE, 3 * (seen.facts.period or 0))
    if seen.silent >= patience:
        return _silent(seen) if seen.facts.trigger_source is None else None
    if seen.unpainted >= patience:
        return Diagnosis(
            Stage.DISPLAY,
            translate("Diagnosis", "Frames arrive but the window does not paint them."),
            translate("Diagnosis", "See the log."),
        )
    if seen.mean is not None and seen.mean < BLACK:
        return _black(seen.facts)
    return None


def _silent(seen: StreamObservation) -> Diagnosis:
    count = seen.statistics
    if seen.silence and _GIGE in seen.bus:
        if count.packets:
            summary = translate("Diagnosis", "Packets arrive, but no frame can be made of them.")
            return Diagnosis(Stage.FRAMES, summary, f"{driver_text(seen.silence)}.")
        return Diagnosis(Stage.PACKETS, _nothing_arrives(seen), f"{driver_text(seen.silence)}.")
    if seen.silence:
        return Diagnosis(
            Stage.PACKETS,
            f"{driver_text(seen.silence)}.",
            translate(
                "Diagnosis",
                "See whether its program sends images, and whether a camera there waits for a trigger.",
            ),
        )
    if count.frames:
        return Diagnosis(
            Stage.FRAMES,
            counted(
                count.frames,
                translate("Diagnosis", "No frame for {1:.0f} s, after 1 frame."),
                translate("Diagnosis", "No frame for {1:.0f} s, after {0} frames."),
                seen.silent,
            ),
            translate("Diagnosis", "Check the cable and the camera's power; then stop and start again."),
        )
    if count.incomplete:
        size = ""
        if seen.facts.packet_size:
            size = translate("Diagnosis", " (GevSCPSPacketSize, now {0} bytes)")
            size = size.format(seen.facts.packet_size)
        return Diagnosis(
            Stage.FRAMES,
            counted(
                count.packets_missing,
                translate("Diagnosis", "Packets arrive, but no frame is complete: 1 packet is missing."),
                translate("Diagnosis", "Packets arrive, but no frame is complete: {0} packets are missing."),
            ),
            translate(
                "Diagnosis",
                "Choose smaller packets{0} or a longer packet delay (GevSCPD); raise net.core.rmem_max.",
            ).format(size),
        )
    if count.packets:
        return Diagnosis(
            Stage.FRAMES,
            counted(
                count.packets,
                translate("Diagnosis", "1 packet arrived, but no frame was finished."),
                translate("Diagnosis", "{0} packets arrived, but no frame was finished."),
            ),
            translate(
                "Diagnosis",
                "The frame rate may be very low, or packets larger than the network's MTU are dropped.",
            ),
        )
    return _no_packets(seen)


def _black(facts: CameraFacts) -> Diagnosis:
    """Blame a black image on the exposure if the camera has one; advise what it, and the user, can do."""
    if facts.playing is not None:
        return Diagnosis(Stage.DISPLAY, translate("Diagnosis", "The recorded image is black."), "")
    summary = translate("Diagnosis", "The image is black.")
    if facts.exposure:
        summary = translate("Diagnosis", "The image is black: the exposure ({0}) may be too short.")
        summary = summary.format(facts.exposure)
    advice = translate("Diagnosis", "Open the iris, or take the lens cap off.")
    brighter = {
        frozenset({Role.EXPOSURE, Role.GAIN}): translate("Diagnosis", "Raise exposure or gain, or press E."),
        frozenset({Role.EXPOSURE}): translate("Diagnosis", "Raise the exposure, or press E."),
        frozenset({Role.GAIN}): translate("Diagnosis", "Raise the gain, or press E."),
    }.get(facts.brightened_by)
    return Diagnosis(Stage.DISPLAY, summary, f"{brighter} {advice}" if brighter else advice)


def _nothing_arrives(seen: StreamObservation) -> str:
    text = translate("Diagnosis", "{0} is under control but sends nothing that arrives here.")
    return text.format(seen.source)


def _no_packets(seen: StreamObservation) -> Diagnosis:
    summary = _nothing_arrives(seen)
    if _GIGE not in seen.bus:
        advice = translate("Diagnosis", "Stop and start again; check the camera's cable and power.")
        return Diagnosis(Stage.PACKETS, summary, advice)
    port = translate("Diagnosis", "UDP port {0}").format(seen.facts.stream_port)
    port = port if seen.facts.stream_port else "UDP"
    allow = translate("Diagnosis", "from the camera")
    command = large = ""
    if seen.address:
        allow = translate("Diagnosis", "from {0}").format(seen.address)
        if seen.facts.stream_port:
            command = f" (sudo ufw allow proto udp from {seen.address} to any port {seen.facts.stream_port})"
    if seen.facts.packet_size and seen.facts.packet_size > 1500:
        large = translate("Diagnosis", " Packets of {0} bytes need an MTU as large on every device between.")
        large = large.format(seen.facts.packet_size)
    advice = translate("Diagnosis", "A firewall may drop it: let {0} {1} pass{2}.{3}")
    return Diagnosis(Stage.PACKETS, summary, advice.format(port, allow, command, large))


def _value(grabber: FeatureSource, name: str) -> FeatureValue | None:
    feature = _feature(grabber, name)
    return None if feature is None else feature.value


def _of_role(grabber: FeatureSource, role: Role) -> Feature | None:
    name = grabber.role(role)
    return None if name is None else _feature(grabber, name)


def _feature(grabber: FeatureSource, name: str) -> Feature | None:
    try:
        return grabber.feature(name) if grabber.has_feature(name) else None
    except GrabberError:
        return None


def _integer(value: FeatureValue | None) -> int | None:
    return int(value) if isinstance(value, int) and value > 0 else None
