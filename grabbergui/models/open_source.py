"""An open source of the window: its state, its thread, and the operator's handle on its grabber."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from enum import Enum

from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, distinct_names, is_same
from grabbergui.core.uri import SourceUri
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import free_text, held_text
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker

log = logging.getLogger(__name__)


class LinkState(Enum):
    """State of a source's connection, as the window shows it."""

    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"
    STREAMING = "streaming"
    LOST = "lost"

    @property
    def connected(self) -> bool:
        """Whether the source's features can be used."""
        return self in (LinkState.OPEN, LinkState.STREAMING)


class OpenSource:
    """One source from being opened to being closed, and the one thread that calls it."""

    def __init__(
        self,
        uri: SourceUri,
        access: Access = Access.CONTROL,
        among: Callable[[], Sequence[OpenSource]] = tuple,
    ) -> None:
        """`among` returns the open sources, from which its names must differ."""
        self.uri = uri
        self._among = among
        self.access = access
        "The access requested on opening."
        self.state = LinkState.OPENING
        self.reason = ""
        "Reason for the state, as display text."
        self.worker = FeatureWorker(f"features {uri}")
        self.grabber: FrameGrabber | None = None
        "None until it is created, on the worker."
        self.tracked_grabber: ChangeTrackingGrabber | None = None
        "The operator's handle on the grabber, which records changes so that they can be undone."
        self.features: FeatureTreeModel | None = None
        "None until the grabber is open, like `tracked_grabber`."
        self.journal = ChangeJournal()
        "The history of its features."
        self.read_only = ""
        "Reason for read-only access as display text; empty if values can be changed."
        self.denied = ""
        "The driver's refusal of control, which names the program that has it if it is known."
        self.held = True
        "Whether another program controls it, while access is read-only."
        self.losses = 0
        "Number of losses since it was opened."
        self.lost_since: float | None = None
        "`time.monotonic` of the present loss; None if it is not lost."
        self.no_frames = ""
        "Why frames are not available while another program has control."
        self.replaces: OpenSource | None = None
        "The source that stays current until this one is open and is closed then."
        self.reopen_on_failure: SourceUri | None = None
        "The source that was closed in order to open this one, to be reopened if that fails."
        self.abandoned = threading.Event()
        "Set when the source is released; later jobs do nothing."

    @property
    def title(self) -> str:
        """Display name, different from that of each other open source."""
        return self.names[0]

    @property
    def names(self) -> tuple[str, ...]:
        """Display names from the longest to the shortest: the title, without the vendor, a short mark."""
        if self.grabber is None:
            return (str(self.uri),)
        info = self.grabber.info
        apart = self._apart(info)
        return info.title + apart, info.short_title + apart, info.mark + apart

    def _apart(self, info: DeviceInfo) -> str:
        """Return what sets it apart from open sources of its title: ` · YARP`. Empty without such sources."""
        others = [
            source.grabber.info
            for source in self._among()
            if source.grabber is not None and source not in (self, self.replaces)
        ]
        twins = [info, *(other for other in others if other.title == info.title)]
        if len(twins) == 1:
            return ""
        return f" · {distinct_names((twin.bus, twin.address, twin.uri) for twin in twins)[0]}"

    def is_named(self, uri: SourceUri) -> bool:
        """Return whether a URI is the requested one or the camera's own."""
        return self.uri == uri or (self.grabber is not None and self.grabber.info.uri == str(uri))

    def is_device(self, other: DeviceInfo) -> bool:
        """Return whether `other` is this camera, as far as its identity is known."""
        return self.grabber is not None and is_same(self.grabber.info, other)

    @property
    def exact_uri(self) -> SourceUri:
        """The URI of exactly this camera: its own if the requested URI means the first camera found."""
        if self.uri.name or self.grabber is None:
            return self.uri
        return SourceUri.parse(self.grabber.info.uri)

    def open_read_only(self, denied: AccessDeniedError) -> None:
        """Open a source for reading only, because another program controls it. Raises `denied` on failure."""
        assert self.grabber is not None
        self.denied = str(denied)
        self.read_only = held_text(denied)  # before the camera reports that control is free by now
        try:
            self.grabber.open(Access.MONITOR)
        except GrabberError as error:
            self.read_only = ""
            log.info("%s, for reading only: %s", self.uri, error)
            raise denied from error

    def note_held(self, held: bool) -> bool:
        """Note whether another program controls it. Return whether `read_only` gives another reason now."""
        if not self.read_only or held is self.held:
            return False
        self.held = held
        self.read_only = held_text() if held else free_text()
        self.no_frames = ""  # the reason named the program
        return True

    def load_features(self) -> None:
        """Create the operator's handle and the feature tree of the open grabber."""
        assert self.grabber is not None
        grabber = ChangeTrackingGrabber(self.grabber, self.journal)
        grabber.open()
        features = FeatureTreeModel(grabber, self.worker, grabber.watch)
        features.structure_changed.connect(grabber.learn)
        self.tracked_grabber, self.features = grabber, features

    def release(self) -> None:
        """Close the source on its own thread after the jobs before, and end the thread. Never waits."""
        self.abandoned.set()
        if self.features is not None:
            self.features.close()
        self.worker.submit(self._close)
        self.worker.close(0)

    def _close(self) -> None:
        if self.features is not None:
            self.features.close()  # a job in progress may have created it after `release`
        if self.tracked_grabber is not None:
            self.tracked_grabber.close()
        if self.grabber is not None:
            self.grabber.close()
