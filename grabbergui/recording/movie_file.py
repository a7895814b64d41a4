"""Reads movies of any kind by FFmpeg's libraries (PyAV)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

import av
import numpy as np
from av.container import InputContainer
from av.error import FFmpegError, InvalidDataError
from av.video.frame import VideoFrame
from av.video.plane import VideoPlane
from av.video.stream import VideoStream
from numpy.typing import NDArray

from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.regular_files import check_regular, open_regular
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.file_names import notes_beside
from grabbergui.recording.notes import FrameNote, read_notes
from grabbergui.recording.reader import RecordingReader
from grabbergui.recording.stored_frames import rebuilt
from grabbergui.recording.times import rising

TIME_BASE = Fraction(1, 1_000_000)
"The unit of a movie's times in seconds."
MAX_FRAMES = 10_000_000
MAX_PIXELS = 1 << 28
"Most pixels of a frame that is decoded, as a damaged or malicious header may claim any size."
NEAR = 8
"Most frames that are decoded to go forward instead of seeking."
_MISSING = "it is missing from the file"
_FORMATS = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi"
"Containers that are opened. Playlists are excluded, as they name other files and hosts."
_BEGINNINGS = ((4, b"ftyp"), (0, b"\x1a\x45\xdf\xa3"), (8, b"AVI "))
"Position and value of the bytes that identify a movie: MP4 and similar, Matroska and WebM, AVI."
_CUT = "is a movie that cannot be read: it was cut off or is damaged"
_DEEP = re.compile(r"(gray|yuv4[0-9]{2}p)(10|12|14)[lb]e")
"FFmpeg's formats with the value in the low bits of 16, as in Mono10."


class MovieRecording(RecordingReader):
    """A movie of any kind. Frames are found by their times, decoding from the key frame before."""

    def __init__(self, path: Path) -> None:
        """Open a movie and index its frames. Raises UsageError."""
        self.path = path
        self.title = path.name
        try:
            check_regular(path)  # FFmpeg would wait for the writer of a FIFO
            self._container: InputContainer = av.open(
                f"file:{path}",
                options={
                    "format_whitelist": _FORMATS,
                    "protocol_whitelist": "file",
                    "max_pixels": str(MAX_PIXELS),
                },
            )
        except (FFmpegError, ValueError) as error:
            raise UsageError(f"{path} {_unreadable(path, error)}") from error
        try:
            self._stream, self._pts = _indexed(path, self._container)
        except BaseException:
            self._container.close()
            raise
        self._stream.thread_type = "AUTO"
        self._frames: Iterator[VideoFrame] = iter(())
        self._next = -1
        notes = list(read_notes(notes_beside(path))) if notes_beside(path).is_file() else []
        # After a crash there may be more or fewer notes than frames.
        count = min(len(notes), len(self._pts)) or len(self._pts)
        self._notes, self._pts = notes[:count], self._pts[:count]
        if self._notes:
            self.times_ns = rising([note.received_ns for note in self._notes])
        else:
            base = self._stream.time_base or TIME_BASE
            self.times_ns = [round((pts - self._pts[0]) * base * 10**9) for pts in self._pts]

    def frame(self, index: int, received_ns: int) -> Frame:
        """Decode a frame, as though it had arrived at `received_ns`. Raises RecordingError."""
        try:
            decoded = self._decoded(index)
        except (FFmpegError, StopIteration) as error:
            self._next = -1
            reason = "its data are damaged" if isinstance(error, InvalidDataError) else str(error) or _MISSING
            raise RecordingError(f"{self.path}: frame {index} cannot be decoded: {reason}") from error
        noted = self._notes[index] if self._notes else None
        pixels, name = _pixels_of(decoded, noted.pixel_format if noted is not None else "")
        height, width = pixels.shape[:2]
        if noted is not None:
            note = replace(noted, width=width, height=height, pixel_format=name)
        else:
            note = FrameNote(width=width, height=height, pixel_format=name, frame_id=index)
        return rebuilt(pixels, note, received_ns)

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._frames = iter(())
        self._container.close()

    def _decoded(self, index: int) -> VideoFrame:
        wanted = self._pts[index]
        if not 0 <= index - self._next <= NEAR or self._next < 0:
            self._seek(wanted)
        frame = next(self._frames)
        if _time_of(frame) > wanted:  # the index leads past the frame, so start from the beginning
            self._seek(self._pts[0])
            frame = next(self._frames)
        while _time_of(frame) < wanted:
            frame = next(self._frames)
        if _time_of(frame) != wanted:
            raise StopIteration(_MISSING)
        self._next = index + 1
        return frame

    def _seek(self, pts: int) -> None:
        self._container.seek(pts, stream=self._stream, backward=True)
        self._frames = self._decode_on()

    def _decode_on(self) -> Iterator[VideoFrame]:
        """Yield the frames from here on, up to a packet that was cut short.

        A decoder on several threads would fail at that packet before it returned the complete frames.
        """
        for packet in self._container.demux(self._stream):
            if packet.is_corrupt:
                yield from self._stream.decode(None)
                return
            yield from self._stream.decode(packet)


def _unreadable(path: Path, error: FFmpegError | ValueError) -> str:
    """Return why a file is no readable movie, as FFmpeg reports `Invalid data` or EIO for most faults."""
    try:
        with open_regular(path) as file:
            begin = file.read(16)
    except OSError as unopened:
        return f"cannot be read: {unopened.strerror}"
    if not begin:
        return "is no movie: it is empty"
    if any(begin[at:].startswith(known) for at, known in _BEGINNINGS):
        return _CUT
    if isinstance(error, InvalidDataError):
        return "is no movie that can be read"
    return f"cannot be read: {getattr(error, 'strerror', None) or error}"


def _indexed(path: Path, container: InputContainer) -> tuple[VideoStream, list[int]]:
    """Return the movie's first video stream and the time of each frame, in units of the stream."""
    if not len(container.streams):
        raise UsageError(f"{path} {_CUT}")
    if not container.streams.video:
        raise UsageError(f"{path} is no movie: there is no video in it")
    stream = container.streams.video[0]
    if stream.codec_context is None:
        raise UsageError(f"{path} is a movie of a codec that this build of PyAV does not have")
    entries = stream.index_entries
    if 0 < len(entries) == stream.frames <= MAX_FRAMES and not stream.codec_context.has_b_frames:
        end = path.stat().st_size  # a file that was cut short may begin with its index
        if times := [entry.timestamp for entry in entries if entry.pos + entry.size <= end]:
            return stream, times
        raise UsageError(f"{path} {_CUT}")
    # There is no index (after a crash, or in Matroska), or frames are stored in another order.
    times = []
    try:
        for packet in container.demux(stream):
            time = packet.pts if packet.pts is not None else packet.dts
            if packet.is_corrupt:
                break  # cut short
            if time is not None and packet.size and not packet.is_discard:
                times.append(time)
            if len(times) > MAX_FRAMES:
                raise UsageError(f"{path} has more than {MAX_FRAMES} frames; cut a part out")
    except FFmpegError:
        pass  # damaged from here on
    if not times:
        raise UsageError(f"{path} holds no movie that can be read, or its recording was cut short")
    return stream, sorted(set(times))


def _time_of(frame: VideoFrame) -> int:
    time = frame.pts if frame.pts is not None else frame.dts
    return -1 if time is None else time


def _grey_bits(frame: VideoFrame) -> int | None:
    """Return the bits of a grey frame of more than 8; None for another.

    FFmpeg decodes H.264 without colour as YUV whose chroma is neutral.
    """
    match = _DEEP.fullmatch(frame.format.name)
    if match is None:
        return None
    bits = int(match[2])
    neutral = np.uint16(1 << (bits - 1))
    if frame.format.name.endswith("be"):
        neutral = neutral.byteswap()
    planes = () if match[1] == "gray" else (1, 2)
    chroma = (np.ascontiguousarray(plane_of(frame, number, 2)).view(np.uint16) for number in planes)
    return bits if all((plane == neutral).all() for plane in chroma) else None


def _pixels_of(frame: VideoFrame, noted: str) -> tuple[NDArray[Any], str]:
    """Return a decoded frame's pixels, and the PFNC name of their format."""
    kind = frame.format.name
    if kind.startswith("gray16"):
        deep = noted if noted.startswith("Mono") and noted != "Mono8" else "Mono16"
        return frame.to_ndarray(format="gray16le"), deep
    if (bits := _grey_bits(frame)) is not None:
        samples = np.ascontiguousarray(plane_of(frame, 0, 2)).view("<u2" if kind.endswith("le") else ">u2")
        return samples.astype("<u2"), f"Mono{bits}"
    if kind == "gray" or (noted == "Mono8" and kind.startswith("yuv")):
        return np.ascontiguousarray(plane_of(frame, 0)), "Mono8"
    colour = frame.to_ndarray(format="rgb24")
    if noted == "Mono8":
        return np.ascontiguousarray(colour[..., 1]), "Mono8"
    return colour, "RGB8"


def plane_of(frame: VideoFrame, number: int, size: int = 1) -> NDArray[np.uint8]:
    """Return a plane without padding: (height, width × size) uint8, of samples of `size` bytes."""
    plane = frame.planes[number]
    return bytes_of(plane).reshape(plane.height, plane.line_size)[:, : plane.width * size]


def bytes_of(plane: VideoPlane) -> NDArray[np.uint8]:
    """Return a plane's memory, including padding; writable if the frame is."""
    return np.asarray(memoryview(cast(bytes, plane)), np.uint8)
