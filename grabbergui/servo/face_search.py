"""A face followed from image to image: near its last place at once, in whole images on a thread of its own.

A search of a whole image costs several times what finding a marker does. On a busy computer the commands that
follow from the image would come late by all of it, so that search runs beside the loop and only says where to
look. A face counts when it is found there in the loop's own, newest image.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time

from typing_extensions import override

from grabbergui.calibration.markers import Grey
from grabbergui.servo.detection import Box, FaceDetection, FaceDetector

AGAIN_S = 0.5
"Seconds between searches of whole images while a face is followed: a nearer person may have come."
MISSES = 5
"Images in a row without the face after which it is searched for everywhere again."
NEARER = 1.3
"Widths of the followed face by which another must be wider to be followed instead."
_NICE = 5
"Nice value of the search beside the loop, so that it takes the loop no time on a busy computer."


class FaceSearch(FaceDetector):
    """Finds the face that is followed. Use from one thread; `close` it."""

    def __init__(self, near: FaceDetector, everywhere: FaceDetector) -> None:
        """Two detectors, as each may be used from one thread only."""
        self._near, self._everywhere = near, everywhere
        self._face: Box | None = None
        self._misses = 0
        self._searched = 0.0
        self._lock = threading.Lock()
        self._given: Grey | None = None
        self._found: FaceDetection | None = None
        self._busy = False
        self._wake = threading.Event()
        self._open = True
        self._thread: threading.Thread | None = None

    @override
    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        """Return the faces near the followed one, or near `near`; none before one was found anywhere.

        The image must not change afterwards: the search beside the loop may still look at it.
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
        """End the search beside the loop. May be called twice."""
        self._open = False
        self._wake.set()
        if self._thread is not None:
            self._thread.join()

    def _take_up_found(self) -> None:
        with self._lock:
            found, self._found = self._found, None
        if found is None:
            return
        if self._face is None or self._misses or found.box[2] > NEARER * self._face[2]:
            self._face, self._misses = found.box, 0

    def _give(self, grey: Grey) -> None:
        """Have the whole image searched, unless one still is."""
        with self._lock:
            if self._busy:
                return
            self._busy, self._given = True, grey
        self._searched = time.monotonic()
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="face search", daemon=True)
            self._thread.start()
        self._wake.set()

    # -- the search's own thread -----------------------------------------------------------------
    def _run(self) -> None:
        if sys.platform == "linux":  # elsewhere a thread has no priority of its own
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)
        while self._wake.wait() and self._open:
            self._wake.clear()
            with self._lock:
                grey, self._given = self._given, None
            if grey is None:
                continue
            began = time.monotonic()
            faces = self._everywhere.detect(grey)
            took = time.monotonic() - began
            with self._lock:
                self._found = max(faces, key=lambda face: face.box[2], default=None)
            # A slow detector leaves half of its core to others.
            self._wake.wait(min(took, AGAIN_S))
            with self._lock:
                self._busy = False
