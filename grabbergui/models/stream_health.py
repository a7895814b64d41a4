"""Health of a stream: losses since the start, and whether there are losses now."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum

from grabbergui.core.grabber import StreamStatistics
from grabbergui.models.language import localized, translate

WINDOW = 5.0
"Seconds that count as now."
NOTABLE = 0.001
"Share of packets sent again that is worth a colour: a few are lost on any network."


class Health(Enum):
    """The quality of the stream in the last seconds."""

    WHOLE = "whole"
    RESENT = "resent"
    "Packets were lost, and arrived when they were requested again."
    LOSING = "losing"
    "Frames were lost or had packets missing."
    OVERRUN = "overrun"
    "More arrives than this computer can take."


@dataclass(frozen=True)
class StreamHealth:
    """The display text for a stream's quality."""

    health: Health = Health.WHOLE
    text: str = ""
    "Short, for the status strip."
    detail: str = ""
    "Every counter since the start, in words."


class HealthMeter:
    """Compares a stream's counters with those of some seconds ago. One thread."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, StreamStatistics]] = deque()

    def judge(self, now: float, statistics: StreamStatistics) -> StreamHealth:
        """Note the counters of this moment, in seconds of any clock that only grows."""
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
    parts = [translate("StreamHealth", "{0} lost · {1} incomplete").format(lost, statistics.incomplete)]
    if share >= NOTABLE:
        parts.append(translate("StreamHealth", "{0} resent").format(localized(f"{share:.1%}")))
    elif statistics.packets_resent:
        parts.append(translate("StreamHealth", "{0} resent").format(statistics.packets_resent))
    return " · ".join(parts)


def _detail(statistics: StreamStatistics) -> str:
    lines = [
        translate("StreamHealth", "Frames since the start: {0}, lost {1}, incomplete {2}").format(
            statistics.frames, statistics.lost, statistics.incomplete
        )
    ]
    if statistics.underruns:
        text = translate("StreamHealth", "Frames dropped because nobody took them in time: {0}")
        lines.append(text.format(statistics.underruns))
    if statistics.packets:
        text = translate("StreamHealth", "Packets: {0}, resent {1}, never arrived {2}")
        lines.append(text.format(statistics.packets, statistics.packets_resent, statistics.packets_missing))
    if statistics.overruns:
        text = translate(
            "StreamHealth",
            "All waiting packets discarded: {0}×; choose larger packets or a lower frame rate",
        )
        lines.append(text.format(statistics.overruns))
    return "\n".join(lines)
