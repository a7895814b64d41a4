"""Writes movies by FFmpeg's libraries (PyAV).

While a movie is written, its MP4 file consists of fragments of half a second with an index each (ISO/IEC
14496-12, 8.8), so that it can be played after a crash or a full disk. Closing the file adds an index of the
whole. Times are in microseconds; the notes beside it (`movie.frames.jsonl`) have those of the camera.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from io import BufferedIOBase
from pathlib import Path
from typing import Any, TextIO, cast

import av
import numpy as np
from av.container import OutputContainer
from av.error import FFmpegError
from av.video.frame import VideoFrame
from av.video.reformatter import ColorRange, Colorspace
from av.video.stream import VideoStream
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.file_names import notes_beside
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.movie_file import TIME_BASE, bytes_of, plane_of
from grabbergui.recording.ordered_work import OrderedWork
from grabbergui.recording.stored_frames import note_of, unpacked
from grabbergui.recording.times import Rising
from grabbergui.recording.writer import RecordingWriter

NOMINAL_RATE = 25.0
"Frames per second in a movie's header if the camera's rate is unknown. Players use the frames' times."
HIGHEST_RATE = 1e6
"Hz. A higher reported rate counts as unknown."
LONGEST_GAP = 600_000_000
"Most units between two frames. Longer pauses are shortened, as MP4 counts durations in 32 bits."
FRAGMENT = 500_000
"Units of time in a fragment, the most that a crash may cost."
_X264 = {"preset": "ultrafast", "g": "25"}


@dataclass(frozen=True)
class _Encoder:
    """One of FFmpeg's encoders, and its pixel formats by FFmpeg's names."""

    name: str
    options: dict[str, str]
    mono: str = "yuv420p"
    "For Mono; every player accepts yuv420p with neutral colour."
    colour: str = "yuv420p"
    deep: str = ""
    "For Mono deeper than 8 bits; empty if such pixels are reduced to their eight highest bits."


_ENCODERS = {
    RecordingKind.H264: _Encoder("libx264", {**_X264, "crf": "20"}),
    # Without losses, separate frames are faster than differences, and need no decoding of those before.
    RecordingKind.LOSSLESS: _Encoder("libx264", {**_X264, "qp": "0", "g": "1"}, "gray", "rgb24"),
    RecordingKind.FFV1: _Encoder(
        "ffv1",
        {"level": "3", "coder": "0", "context": "0", "slices": "16", "slicecrc": "1", "g": "1"},
        "gray",
        "bgr0",
        deep="gray16le",
    ),
}


class MovieFile:
    """An MP4 file that is being written. One thread at a time."""

    def __init__(
        self, path: Path, kind: RecordingKind, shape: tuple[int, ...], dtype: Any, rate: float
    ) -> None:
        """Begin a movie of frames of one shape: (height, width) or (height, width, 3). `rate` is in Hz.

        Raises RecordingError if the encoder is missing or does not accept the size, OSError.
        """
        self.size = 0
        "Bytes encoded so far."
        self.written = 0
        "Bytes in the file, to which fragments are written as a whole."
        self._encoder = _ENCODERS[kind]
        self._path = path
        self._last = -1
        self._failure: RecordingError | OSError | None = None
        "The error that ended the movie early, which every further call raises."
        height, width = shape[:2]
        self._format = self._format_for(width, height, colour=len(shape) == 3, deep=dtype == np.uint16)
        name = "libx264rgb" if self._format == "rgb24" else self._encoder.name
        self._file: BufferedIOBase = path.open("xb")
        try:
            self._container: OutputContainer = av.open(
                self._file,
                "w",
                format="mp4",
                options={
                    "movflags": "hybrid_fragmented",
                    "frag_duration": str(FRAGMENT),
                    "video_track_timescale": str(TIME_BASE.denominator),
                },
                buffer_size=1 << 20,
            )
            stream = cast(VideoStream, self._container.add_stream(name, options=dict(self._encoder.options)))
            stream.width, stream.height, stream.pix_fmt = width, height, self._format
            context = stream.codec_context
            context.framerate = Fraction(rate).limit_denominator(1000)
            context.time_base = stream.time_base = TIME_BASE
            context.thread_type, context.thread_count = "SLICE" if name == "ffv1" else "AUTO", 0
            full = self._format.startswith(("gray", "rgb", "bgr")) or len(shape) == 2
            context.color_range = ColorRange.JPEG if full else ColorRange.MPEG
            if not full:
                context.colorspace = Colorspace.ITU709
            context.open()
        except (FFmpegError, ValueError) as error:
            self._file.close()
            path.unlink(missing_ok=True)
            reason = getattr(error, "strerror", None) or error
            raise RecordingError(
                f"{path}: {name} cannot encode {width}×{height} pixels here ({reason}); try another kind"
            ) from error
        self._stream = stream

    def add(self, pixels: NDArray[Any], time: int) -> None:
        """Encode a frame with its time in microseconds. Raises RecordingError, OSError.

        A frame that is not later than the one before is moved to one microsecond after it.
        """
        if self._last >= 0:
            time = min(max(time, self._last + 1), self._last + LONGEST_GAP)
        frame = self._video_frame(pixels)
        frame.pts, frame.time_base = time, TIME_BASE
        self._last = time
        self._mux(frame)

    def finish(self) -> None:
        """Write the frames left in the encoder, and the index. Raises RecordingError, OSError."""
        self._mux(None)
        try:
            self._container.close()
        except FFmpegError as error:
            raise self._explained(error) from error
        self._file.close()

    def abandon(self) -> None:
        """Close the file without an index; its complete fragments can be played."""
        with contextlib.suppress(FFmpegError, OSError):
            self._container.close()
        with contextlib.suppress(OSError):
            self._file.close()

    def _mux(self, frame: VideoFrame | None) -> None:
        if self._failure is not None:
            raise self._failure
        try:
            for packet in self._stream.encode(frame):
                self.size += packet.size
                self._container.mux(packet)
                if (written := self._file.tell()) > self.written:  # the fragment before this packet
                    self._file.flush()
                    self.written = written
        except (FFmpegError, OSError) as error:
            self._failure = self._explained(error)
            raise self._failure from error

    def _explained(self, error: FFmpegError | OSError) -> RecordingError | OSError:
        """Return the error to raise: an OSError itself, a RecordingError for others."""
        if isinstance(error, OSError):
            return error
        return RecordingError(f"{self._path} could not be written: {error}")

    def _format_for(self, width: int, height: int, *, colour: bool, deep: bool) -> str:
        encoder = self._encoder
        chosen = encoder.colour if colour else encoder.deep if deep and encoder.deep else encoder.mono
        if chosen != "yuv420p" or not (width % 2 or height % 2):
            return chosen
        return "yuv444p" if colour else "gray"

    def _video_frame(self, pixels: NDArray[Any]) -> VideoFrame:
        pixels = np.ascontiguousarray(pixels)
        if pixels.ndim == 3:
            frame = VideoFrame.from_numpy_buffer(pixels, "rgb24")
            if self._format == "rgb24":
                return frame
            if self._format == "bgr0":
                return frame.reformat(format="bgr0")
            return frame.reformat(
                format=self._format,
                dst_colorspace=Colorspace.ITU709,
                dst_color_range=ColorRange.MPEG,
            )
        if self._format == "gray":
            return VideoFrame.from_numpy_buffer(pixels, "gray")
        if self._format == "gray16le":
            return VideoFrame.from_ndarray(pixels, "gray16le")
        frame = VideoFrame(pixels.shape[1], pixels.shape[0], self._format)
        frame.color_range = ColorRange.JPEG
        plane_of(frame, 0)[:] = pixels
        for number in (1, 2):
            bytes_of(frame.planes[number])[:] = 128
        return frame


class MovieWriter(RecordingWriter):
    """Writes a movie, and the notes of its frames beside it.

    The caller's thread converts the next frame while another encodes; the encoder has threads of its own.
    """

    def __init__(self, path: Path, kind: RecordingKind, rate: float) -> None:
        """Begin a movie of one of `MOVIE_KINDS`; `rate` is the camera's in Hz, 0 if unknown."""
        self.path = path
        self._kind = kind
        self._rate = rate if 0 < rate <= HIGHEST_RATE else NOMINAL_RATE
        self._notes: TextIO = notes_beside(path).open("x", encoding="utf-8", buffering=1)
        self._movie: MovieFile | None = None
        self._made = False
        "Whether the file was created here. Before the first frame, another program may create it."
        self._shape: tuple[tuple[int, ...], Any] | None = None
        self._first = 0
        self._clock = Rising()
        self._broken = False
        self._work = OrderedWork(f"encode {path.name}", 1, 2, self._notes.write)

    def write(self, frame: Frame) -> None:
        """Add a frame. Raises RecordingError if its size or kind is not that of the first."""
        pixels, name = self._pixels(frame)
        shape = (pixels.shape, pixels.dtype)
        if self._movie is None:
            self._movie = MovieFile(self.path, self._kind, *shape, self._rate)
            self._made = True
            self._shape, self._first = shape, frame.received_ns
        if shape != self._shape:
            raise RecordingError(
                f"{self.path}: the frames' size or format changed; a movie cannot follow, .mcap can"
            )
        time = max(0, (self._clock.next(frame.received_ns) - self._first) // 1000)
        line = note_of(frame, pfnc.by_name(name)).line()
        try:
            self._work.add(partial(_encode, self._movie, pixels, time, line))
        except BaseException:
            self._broken = True
            raise

    def close(self) -> None:
        """Finish the file. After a failed write it remains fragmented, which players accept."""
        movie, self._movie = self._movie, None
        try:
            with contextlib.suppress(RecordingError, OSError) if self._broken else contextlib.nullcontext():
                self._work.finish()
            if movie is not None and not self._broken:
                movie.finish()
        except BaseException:
            self._broken = True
            raise
        finally:
            self._notes.close()
            if movie is not None:
                movie.abandon()

    def free(self) -> int:
        """Return the free bytes minus those that wait to be written, up to half a second's."""
        held = self._movie.size - self._movie.written if self._movie is not None else 0
        return super().free() - held

    def discard(self) -> None:
        """Remove the movie, if it was created, and its notes."""
        notes_beside(self.path).unlink(missing_ok=True)
        if self._made:
            super().discard()

    def size(self) -> int:
        """Return the bytes encoded, or those of the finished file."""
        if self._movie is not None:
            return self._movie.size
        return self.path.stat().st_size if self._made else 0

    def _pixels(self, frame: Frame) -> tuple[NDArray[Any], str]:
        """Return the pixels of a frame to encode, and the PFNC name of their format."""
        if frame.pixel_format.family not in (Family.MONO, Family.COORDINATES):
            return frame.rgb(), "RGB8"
        if _ENCODERS[self._kind].deep and frame.raw().dtype == np.uint16 and frame.raw().ndim == 2:
            pixels, pixel_format = unpacked(frame)
            return pixels, pixel_format.name
        return frame.mono(), "Mono8"


def _encode(movie: MovieFile, pixels: NDArray[Any], time: int, line: str) -> str:
    """Encode a frame, and return its note."""
    movie.add(pixels, time)
    return line
