"""A source that another program serves: where it is, by which network it comes, how old its image is."""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.models.language import localized, translate
from grabbergui.models.open_source import OpenSource
from grabbergui.sources import SourceKind

LEAST_AGE = 0.1
"Seconds; shorter ages are not distinguished, as the screen shows each image for as long."
_REMOTE = (SourceKind.YARP.value, SourceKind.ROS2.value)


@dataclass(frozen=True)
class RemoteSource:
    """The way by which an image reaches this window."""

    network: str
    name: str
    "Name of the port or topic."
    host: str
    "The computer or node that sends; empty if the network does not report it."

    @classmethod
    def of(cls, source: OpenSource | None) -> RemoteSource | None:
        """Return the way of an open source; None for a camera of this computer."""
        if source is None or source.grabber is None or source.uri.scheme not in _REMOTE:
            return None
        info = source.grabber.info
        return cls(info.bus, info.address, info.interface)

    def text(self, age: float | None) -> str:
        """Return it as display text, a few words; `age` of the shown image is in seconds."""
        return " · ".join(filter(None, (f"{self.network} {self.name}", _age_text(age))))

    def detail(self, age: float | None) -> str:
        """Return it as whole sentences."""
        place = translate("Remote", "{0} from {1}").format(self.name, self.host) if self.host else self.name
        text = translate("Remote", "A remote camera: {0} over {1}.").format(place, self.network)
        shown = translate("Remote", "The shown image is {0}.").format(_age_text(age))
        return text if age is None else f"{text}\n{shown}"


def _age_text(age: float | None) -> str:
    if age is None:
        return ""
    if age < LEAST_AGE:
        return translate("Remote", "under {0} s old").format(localized(f"{LEAST_AGE:g}"))
    return translate("Remote", "{0} s old").format(localized(f"{age:.1f}" if age < 10 else f"{age:.0f}"))
