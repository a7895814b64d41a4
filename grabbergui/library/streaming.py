"""Frames as iterators, for `for` and `async for`, recordings beside them, and when a camera is closed.

`StreamUse` counts the users of a stream, because the end of one loop must not stop it for others. `Closing`
closes cameras that the program leaves open, with the last reference to them or when the program exits: a GigE
Vision camera that was not released refuses every program for some seconds, and a movie that was not finished
lacks its end.
"""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import functools
import itertools
import os
import threading
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from grabbergui.core.errors import GrabberError, StreamEndedError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.library.arguments import checked_count, checked_depth
from grabbergui.library.collected import await_ends, when_collected
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import Recorder, RecordingLimits, RecordingProgress, create_recorder

DEPTH = 8
"Frames that may wait for the loop; older ones are dropped and counted."

Get = Callable[[FrameQueue, float], Frame]
"Takes the next frame of a queue within a time-out, in seconds, or raises an error that says why none came."
Item = TypeVar("Item")
Use = Callable[[], AbstractContextManager[None]]
"Has the stream on as long as the context lasts; raises what starting it raises."
_CLOSING: set[threading.Thread] = set()


class StreamUse:
    """Switches a camera's stream on for loops, recordings and grabs, and off when it may be off again.

    A stream that a loop or a recording switched on is switched off with the last of them. It stays on if it
    was on before, if the program has switched it on since (`keep`), or while a `grab` waits. Any thread
    may call.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._process = os.getpid()
        self._lock = threading.RLock()
        self._loops = 0
        self._grabs = 0
        self._temporary = False
        "Whether the stream is on for loops and recordings only."

    def keep(self) -> None:
        """Leave the stream on after the loops and recordings in progress."""
        self._temporary = False

    @contextlib.contextmanager
    def loop(self, start: Callable[[], None]) -> Iterator[None]:
        """Switch the stream on by `start`, and off at the end if nobody else uses it. Raises as `start`."""
        with self._lock:
            self._loops += 1
        try:
            with self._lock:
                self._temporary |= not self._grabber.streaming
                start()
            yield
        finally:
            if os.getpid() == self._process:  # in a forked process the stream is its parent's
                self._end_of_loop()

    def _end_of_loop(self) -> None:
        with self._lock:
            self._loops -= 1
            if not self._loops:
                self._switch_off()

    def _switch_off(self) -> None:
        temporary, self._temporary = self._temporary, False
        if temporary and not self._grabs:
            with contextlib.suppress(GrabberError):  # it may be lost, or closed inside the loop
                self._grabber.stop()

    @contextlib.contextmanager
    def grab(self) -> Iterator[None]:
        """Keep the stream, which the caller starts, on during the block."""
        with self._lock:
            self._grabs += 1
        try:
            yield
        finally:
            with self._lock:
                self._grabs -= 1


class Frames:
    """The next frames of a camera, as an iterable: `for frame in camera.frames(100)`.

    The stream runs while the loop does. If it was off before, it is switched off at the loop's end, also
    after `break` or an error, unless another loop, a recording or a `grab` uses it then. A loop that is
    slower than the camera loses the oldest frames; `dropped` counts them. Each `for` starts over. A recording
    waits for a slow loop, unless another consumer is faster; behind its last frame (`?loop=0`) the loop ends.
    """

    def __init__(
        self,
        grabber: FrameGrabber,
        use: Use,
        get: Get,
        count: int | None,
        timeout: float,
        depth: int,
    ) -> None:
        self._grabber = grabber
        self._use = use
        self._get = get
        self._count = checked_count("frames", count)
        self._timeout = timeout
        self._depth = checked_depth("frames", depth)
        self._queue: FrameQueue | None = None
        self._dropped = 0

    @property
    def dropped(self) -> int:
        """Frames that the loop was too slow for, so far or in the last loop."""
        return self._queue.dropped if self._queue is not None else self._dropped

    def __iter__(self) -> FrameLoop[Frame]:
        stack, frames = contextlib.ExitStack(), None
        try:
            frames = stack.enter_context(self.started())
            return FrameLoop(frames, stack)
        except BaseException:
            stack.close()
            raise

    @contextlib.contextmanager
    def started(self) -> Iterator[Iterator[Frame]]:
        """Stream during the block, and return the iterator for `next(frames)`, which may follow a time-out.

        So a program can start several cameras before their trigger, wait for the next pulse once more, or for
        a camera that is lost.
        """
        queue = self._queue = self._grabber.open_queue(self._depth)
        queue.needs_all = True
        count = () if self._count is None else (self._count,)
        take = map(functools.partial(self._next, queue), itertools.repeat(self._timeout, *count))
        try:
            with self._use():
                yield iter(take.__next__, None)  # no generator, which an error such as a time-out would end
        finally:
            self._queue, self._dropped = None, queue.dropped
            queue.close()

    def _next(self, queue: FrameQueue, timeout: float) -> Frame | None:
        """Return the next frame, or None at the end of the stream."""
        try:
            return self._get(queue, timeout)
        except StreamEndedError:
            return None


class FrameLoop(Iterator[Item]):
    """The iterator of one loop. It ends the use of the stream: at its end, on an error, or when it is left.

    A loop that the program leaves by `break` or an exception of its own ends on a thread of the library
    (`collected`), at once. It is no generator: the code in a generator's `finally` would run in a finaliser.
    """

    def __init__(self, frames: Iterator[Item], stream: contextlib.ExitStack) -> None:
        """Iterate over frames, or sets of them; `stream` is closed at the end."""
        self._frames = frames
        self._stream = stream
        self._left = when_collected(self, stream.close)

    def __next__(self) -> Item:
        try:
            return next(self._frames)
        except BaseException:  # StopIteration, too
            self.close()
            raise

    def close(self) -> None:
        """End the loop. May be called twice."""
        self._frames = iter(())
        self._stream.close()
        self._left.cancel()


class AsyncFrames:
    """The next frames of a camera for any asyncio loop: `async for frame in camera.aframes(100)`.

    As `Frames`; the loop is never blocked. Waiting for frames, starting and stopping happen on a thread of
    its own.
    """

    def __init__(self, frames: Frames) -> None:
        self._frames = frames

    @property
    def dropped(self) -> int:
        """Frames that the loop was too slow for, so far or in the last loop."""
        return self._frames.dropped

    def __aiter__(self) -> AsyncIterator[Frame]:
        return self._iterate()

    async def _iterate(self) -> AsyncGenerator[Frame]:
        loop = asyncio.get_running_loop()
        frames = iter(self._frames)
        thread = ThreadPoolExecutor(1, "camera frames")
        try:
            while (frame := await loop.run_in_executor(thread, next, frames, None)) is not None:
                yield frame
        finally:
            # A cancelled task leaves a `next` behind on the thread; closing queues up behind it.
            thread.submit(frames.close)
            thread.shutdown(wait=False)


class Recording:
    """A recording in progress: `with camera.record("run.mcap") as recording: …`, or `.wait()` for its limit.

    The file is complete and can be read once `stop` or the `with` block has returned, at the latest when the
    program has ended.
    """

    def __init__(self, recorder: Recorder, stream: contextlib.ExitStack) -> None:
        """`stream` is the use of the camera's stream, which is closed with the recording."""
        self._recorder = recorder
        self._stream = stream
        self._process = os.getpid()
        atexit.register(self._finish)

    @classmethod
    def begin(
        cls, grabber: FrameGrabber, path: Path, kind: RecordingKind, limits: RecordingLimits, use: Use
    ) -> Recording:
        """Start writing the frames that arrive from now on. Raises GrabberError where it cannot be made."""
        return begun(create_recorder(grabber, path, kind, limits), use)

    @property
    def path(self) -> Path:
        """The file or folder that is written."""
        return self._recorder.writer.path

    @property
    def progress(self) -> RecordingProgress:
        """Frames written and dropped, seconds, bytes, and why it ended if it did so by itself."""
        return self._recorder.progress

    def wait(self, timeout: float | None = None) -> RecordingProgress:
        """Wait until the recording reaches its limit, at most `timeout` seconds, then finish it.

        Raises GrabberError if it ended before for another reason: a full disk, a lost source.
        """
        self._recorder.wait(timeout)
        return self.stop()

    def stop(self) -> RecordingProgress:
        """Finish the file. May be called twice. Raises GrabberError if the recording failed before."""
        self._finish()
        if self.progress.reason:
            raise GrabberError(self.progress.reason)
        return self.progress

    def _finish(self) -> None:
        atexit.unregister(self._finish)
        if os.getpid() != self._process:
            return  # a forked process: the recording is its parent's
        self._recorder.stop()
        self._recorder.wait()
        self._stream.close()

    def __enter__(self) -> Recording:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.stop()
        else:
            with contextlib.suppress(GrabberError):
                self.stop()


def begun(recorder: Recorder, use: Use) -> Recording:
    """Start a recorder, with the stream on. Raises what `use` raises."""
    stream = contextlib.ExitStack()
    recorder.start()
    try:
        stream.enter_context(use())
    except BaseException:
        recorder.stop()
        recorder.wait()
        raise
    return Recording(recorder, stream)


class Closing:
    """Calls `close` once: on request, when the owner is collected, or when the program exits."""

    def __init__(self, owner: object, close: Callable[[], None]) -> None:
        """`close` must not refer to `owner`, which would never be collected."""
        self._close = close
        self._process = os.getpid()
        self._collected = when_collected(owner, self._begin)
        atexit.register(self.now)

    def now(self) -> None:
        """Close. May be called twice. A forked process has nothing to close: all is its parent's."""
        if os.getpid() == self._process:
            if threading.current_thread() is threading.main_thread():
                self._close_undisturbed()
            else:
                self._close()
        # Last, so that a close that Ctrl-C interrupted before it began still happens at exit.
        self._collected.cancel()
        atexit.unregister(self.now)

    def _close_undisturbed(self) -> None:
        """Close on a thread: Ctrl-C ends the wait, but does not leave a camera half closed."""
        thread = threading.Thread(target=self._close, name="close camera")
        try:
            thread.start()
        except RuntimeError:  # the program ends
            self._close()
            return
        _CLOSING.add(thread)
        thread.join()
        _CLOSING.discard(thread)

    def _begin(self) -> None:
        """Close on a thread of its own, so that no other camera waits for this one."""
        if os.getpid() == self._process:
            thread = threading.Thread(target=self.now, name="close camera")
            with contextlib.suppress(RuntimeError):  # the program ends, and `now` will be called
                thread.start()
                _CLOSING.add(thread)


def await_collected() -> None:
    """Wait until collected cameras are closed. Do not call it from their callbacks."""
    await_ends()
    for thread in tuple(_CLOSING):
        if thread is not threading.current_thread():
            thread.join()
            _CLOSING.discard(thread)
