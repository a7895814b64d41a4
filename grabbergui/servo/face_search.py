"""The search for faces in whole images, on a thread of its own.

It takes several times as long as to find a marker, and would delay the image's command by as much on a busy
computer. So the search only shows the loop where to look: a face counts if the loop finds it there in its
own, newest image.
"""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import threading
import time

from typing_extensions import override

from grabbergui.calibration.markers import Grey
from grabbergui.servo.detection import Box, FaceDetection, FaceDetector

log = logging.getLogger(__name__)

AGAIN_S = 0.5
"Seconds between searches of whole images while a face is followed, as a nearer person may appear."
MISSES = 5
"Images in a row without the face after which it is lost."
_NEARER = 1.3
"Factor by which another face must be wider than the followed one to be followed instead."
_NICE = 5
"Nice value of the search's thread, so that it does not delay the loop on a busy computer."


class FaceSearch(FaceDetector):
    """Follows one face, and searches whole images on a thread of its own. Use from one thread; `close` it."""

    def __init__(self, near: FaceDetector, everywhere: FaceDetector) -> None:
        """Needs two detectors, as each may be used from one thread only."""
        self._near, self._everywhere = near, everywhere
        self._face: Box | None = None
        self._misses = 0
        self._searched = 0.0
        self._lock = threading.Lock()
        self._given: Grey | None = None
        self._found: FaceDetection | None = None
        self._busy = False
        self._complaint = ""
        "The last error that was logged."
        self._wake = threading.Event()
        self._open = True
        self._thread: threading.Thread | None = None

    @override
    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        """Return the faces near `near`, or near the followed one; none before one was found.

        The image must not change afterwards, as the search may still read it.
        """
        self._take_up_found()
        near = near or self._face
        faces = [] if near is None else self._near.detect(grey, near)
        followed = max(faces, key=lambda face: face.box[2], default=None)
        if followed is not None:
            self._face, self._misses = followed.box, 0
        elif self._face is not None:
            self._misses += 1
            self._face = None if self._misses >= MISSES else self._face
        if self._misses or self._face is None or time.monotonic() - self._searched >= AGAIN_S:
            self._give(grey)
        return faces

    def close(self) -> None:
        """End the search's thread. May be called twice."""
        self._open = False
        self._wake.set()
        if self._thread is not None:
            self._thread.join()

    def _take_up_found(self) -> None:
        with self._lock:
            found, self._found = self._found, None
        if found is None:
            return
        if self._face is None or self._misses or found.box[2] > _NEARER * self._face[2]:
            self._face, self._misses = found.box, 0

    def _give(self, grey: Grey) -> None:
        """Pass the image to the search, unless it still searches another."""
        with self._lock:
            if self._busy:
                return
            self._busy, self._given = True, grey
        self._searched = time.monotonic()
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="face search", daemon=True)
            self._thread.start()
        self._wake.set()

    def _searched_everywhere(self, grey: Grey) -> list[FaceDetection]:
        try:
            return self._everywhere.detect(grey)
        except Exception as error:  # OpenCV's own among them; the next image may be searched without one
            if str(error) != self._complaint:
                log.error("a search for faces failed: %s", error)
            self._complaint = str(error)
            return []

    def _run(self) -> None:
        if sys.platform == "linux":  # on other systems a thread has no nice value of its own
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)
        while True:
            self._wake.wait()
            self._wake.clear()  # before `_open` is read, or a `close` in between would be missed
            if not self._open:
                return
            with self._lock:
                grey, self._given = self._given, None
            if grey is None:
                continue
            began = time.monotonic()
            faces = self._searched_everywhere(grey)
            took = time.monotonic() - began
            with self._lock:
                self._found = max(faces, key=lambda face: face.box[2], default=None)
            # A slow detector leaves half of its core idle.
            self._wake.wait(min(took, AGAIN_S))
            with self._lock:
                self._busy = False
