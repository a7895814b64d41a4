"""A movie as OpenCV decodes it, with the recorder's notes beside it where there are any."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.recording.recording import DEFAULT_RATE, Recording, rising
from grabbergui.recording.stored import FrameNote, RecordingError, read_notes, rebuilt

MAX_FRAMES = 10_000_000


def notes_beside(path: Path) -> Path:
    """Where the times of a movie's frames are: `movie.frames.jsonl` beside `movie.mp4`."""
    return path.with_name(path.stem + ".frames.jsonl")


class VideoRecording(Recording):
    """Frames of 8 bits; going back decodes from the last key frame."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.title = path.name
        self._capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
        count = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT)) if self._capture.isOpened() else 0
        if not 0 < count <= MAX_FRAMES:
            self._capture.release()
            raise UsageError(f"{path} holds no movie that can be read, or its recording was cut short")
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        rate = rate if 0 < rate < 1e5 else DEFAULT_RATE
        self._next = 0
        notes = list(read_notes(notes_beside(path))) if notes_beside(path).is_file() else []
        self._notes = notes[:count]
        if self._notes:
            self.times_ns = rising([note.received_ns for note in self._notes])
        else:
            self.times_ns = [round(index * 1e9 / rate) for index in range(count)]
        mono = bool(self._notes) and all(note.pixel_format == "Mono8" for note in self._notes)
        self._mono = mono

    def frame(self, index: int, received_ns: int) -> Frame:
        """See Recording."""
        try:
            if index != self._next:
                self._capture.set(cv2.CAP_PROP_POS_FRAMES, index)
            read, pixels = self._capture.read()
        except cv2.error as error:
            self._next = -1
            raise RecordingError(f"{self.path}: frame {index} cannot be decoded: {error}") from error
        self._next = index + 1 if read else -1
        if not read or pixels is None:
            raise RecordingError(f"{self.path}: frame {index} cannot be decoded")
        if self._mono:
            # Decoded to three equal components; any is the grey that went in.
            pixels = pixels[..., 1] if pixels.ndim == 3 else pixels
            name = "Mono8"
        else:
            name = "BGR8"
        height, width = pixels.shape[:2]
        note = FrameNote(width=width, height=height, pixel_format=name, frame_id=index)
        if self._notes:
            note = replace(self._notes[index], width=width, height=height, pixel_format=name)
        return rebuilt(np.ascontiguousarray(pixels), note, received_ns)

    def close(self) -> None:
        """See Recording."""
        self._capture.release()
