"""One source from being opened to being closed."""

from __future__ import annotations

import logging
import threading
from enum import Enum

from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.grabber import Access, DeviceInfo, FrameGrabber
from grabbergui.core.identity import is_same
from grabbergui.core.uri import SourceUri
from grabbergui.models.changes.journal import ChangeJournal
from grabbergui.models.changes.tracking import NotingGrabber
from grabbergui.models.error_text import held_text
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker

log = logging.getLogger(__name__)


class LinkState(Enum):
    """Where the connection stands, as the window shows it."""

    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"
    STREAMING = "streaming"
    LOST = "lost"

    @property
    def connected(self) -> bool:
        """Whether there is a source whose features can be used."""
        return self in (LinkState.OPEN, LinkState.STREAMING)


class OpenSource:
    """One source from being opened to being closed, and the one thread that calls it."""

    def __init__(self, uri: SourceUri, access: Access = Access.CONTROL) -> None:
        self.uri = uri
        self.access = access
        "What is asked for on opening."
        self.state = LinkState.OPENING
        "Where it stands."
        self.reason = ""
        "Why, for people."
        self.worker = FeatureWorker(f"features {uri}")
        self.grabber: FrameGrabber | None = None
        "None until it is created, on the worker."
        self.hands: NotingGrabber | None = None
        "The operator's handle on the grabber: what is done with it can be looked at and undone."
        self.features: FeatureTreeModel | None = None
        "None until the grabber is open, and so is `hands`."
        self.journal = ChangeJournal()
        "What happened to its features."
        self.streaming_since: float | None = None
        "`time.monotonic` of the last start."
        self.read_only = ""
        "Why values can be looked at but not changed, for people; empty where they can be changed."
        self.losses = 0
        "How often it was lost since it was opened."
        self.lost_since: float | None = None
        "`time.monotonic` of the last loss, while it lasts."
        self.no_picture = ""
        "Why the picture cannot be had beside the program that has control."
        self.instead_of: OpenSource | None = None
        "What stays at hand until this one is open, and is closed then."
        self.comes_back: SourceUri | None = None
        "What had to be closed to open this one, and is opened again where that fails."
        self.abandoned = threading.Event()
        "Set when nobody wants it any more; a job that has not begun then does nothing."

    @property
    def title(self) -> str:
        """The name for people."""
        return self.grabber.info.title if self.grabber is not None else str(self.uri)

    @property
    def short_title(self) -> str:
        """The same without the vendor, where there is little room."""
        return self.grabber.info.short_title if self.grabber is not None else str(self.uri)

    def is_named(self, uri: SourceUri) -> bool:
        """Whether a URI is how it was asked for, or what it calls itself."""
        return self.uri == uri or (self.grabber is not None and self.grabber.info.uri == str(uri))

    def is_device(self, other: DeviceInfo) -> bool:
        """Whether another name leads to this camera, as far as it says who it is."""
        return self.grabber is not None and is_same(self.grabber.info, other)

    @property
    def exact_uri(self) -> SourceUri:
        """The URI that leads to this camera again: the camera's own if only the first found was asked for."""
        if self.uri.name or self.grabber is None:
            return self.uri
        return SourceUri.parse(self.grabber.info.uri)

    def open_beside(self, denied: AccessDeniedError) -> None:
        """Look at what another program controls. Raises `denied` where even that is not possible."""
        assert self.grabber is not None
        try:
            self.grabber.open(Access.MONITOR)
        except GrabberError as error:
            log.info("%s, for reading only: %s", self.uri, error)
            raise denied from error
        self.read_only = held_text(denied)

    def equip(self) -> None:
        """Put the operator's handle and the tree of features on the open grabber."""
        assert self.grabber is not None
        hands = NotingGrabber(self.grabber, self.journal)
        hands.open()
        features = FeatureTreeModel(hands, self.worker, hands.watch)
        features.structure_changed.connect(hands.learn)
        self.hands, self.features = hands, features

    def let_go(self) -> None:
        """Close it after the job at hand, on its own thread, which then ends. Never waits."""
        self.abandoned.set()
        if self.features is not None:
            self.features.close()
        self.worker.submit(self._close)
        self.worker.close(0)

    def _close(self) -> None:
        if self.features is not None:
            self.features.close()  # made by a job that was under way when it was let go
        if self.hands is not None:
            self.hands.close()
        if self.grabber is not None:
            self.grabber.close()
