import gc
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from grabbergui.core.component import Component, ComponentKind
from grabbergui.core.frame import FEWEST_BUFFERS, MOST_BUFFERS, BufferPool, Frame, FrameStatus, time_of_day
from grabbergui.core.pfnc import by_name
from patience import PATIENCE


def address(array):
    return array.__array_interface__["data"][0]


def test_a_buffer_is_writable_and_has_the_requested_size():
    array = BufferPool(1000).take()
    array[:] = 7
    assert array.shape == (1000,) and array.dtype == np.uint8 and array.sum() == 7000


def test_a_released_buffer_is_reused():
    pool = BufferPool(1000)
    array = pool.take()
    first = address(array)
    assert pool.in_use == 1
    del array
    assert pool.in_use == 0
    assert address(pool.take()) == first


@pytest.mark.parametrize(
    "look",
    [
        lambda array: array[10:20],
        lambda array: array[:100].reshape(10, 10)[::2, ::2],
        lambda array: array.view("<u2")[3:],
        lambda array: np.ndarray((4, 4), "<u2", array, 1, (17, 2)),
        lambda array: memoryview(array),
        lambda array: Frame(array, 10, 10, by_name("Mono8")).mono(),
    ],
    ids=["slice", "strided", "other dtype", "ndarray over it", "memoryview", "a frame's image"],
)
def test_a_buffer_stays_in_use_as_long_as_any_view_of_it(look):
    pool = BufferPool(1000)
    array = pool.take()
    view = look(array)
    del array
    gc.collect()
    assert pool.in_use == 1
    del view
    gc.collect()
    assert pool.in_use == 0


def test_no_more_buffers_than_the_limit_are_in_use():
    pool = BufferPool(10, limit=3)
    held = [pool.take() for _ in range(3)]
    assert pool.take() is None
    assert len({address(array) for array in held}) == 3
    held.pop()
    assert pool.take() is not None


def test_a_buffer_may_outlive_its_pool():
    array = BufferPool(10).take()
    gc.collect()
    array[:] = 1
    assert array.sum() == 10


def test_many_threads_take_and_drop():
    pool = BufferPool(64, limit=8)
    clashes = []

    def work(mark):
        for _ in range(500):
            array = pool.take()
            if array is None:
                continue
            array[:] = mark
            if (array != mark).any():
                clashes.append(mark)

    with ThreadPoolExecutor(4) as threads:
        list(threads.map(work, range(1, 5)))
    assert not clashes
    assert pool.in_use == 0


def test_a_buffer_found_by_the_collector_inside_take_does_not_deadlock():
    """A garbage collection may run the finaliser on the thread that holds the pool's lock."""
    pool = BufferPool(10)
    array = pool.take()

    def work():
        nonlocal array
        with pool._lock:
            array = None
            assert pool.take() is not None

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(PATIENCE)
    assert not thread.is_alive()


@pytest.mark.parametrize(
    ("size", "limit"),
    [(100, MOST_BUFFERS), (1 << 20, 512), (32 << 20, 16), (1 << 30, FEWEST_BUFFERS), (0, MOST_BUFFERS)],
)
def test_without_a_limit_memory_limits_the_number_of_buffers(size, limit):
    assert BufferPool(size).limit == limit


def test_a_pool_without_memory_returns_none_and_still_works():
    pool = BufferPool(1 << 62)
    assert pool.take() is None
    assert pool.in_use == 0


def test_no_python_code_runs_when_a_buffer_is_released():
    """It would swallow the KeyboardInterrupt of a Ctrl-C that comes at that moment."""
    pool = BufferPool(1000)
    view = pool.take()[5:]
    calls = []
    sys.setprofile(lambda frame, event, _: calls.append(frame.f_code.co_name) if event == "call" else None)
    try:
        del view
    finally:
        sys.setprofile(None)
    assert calls == [] and pool.in_use == 0


def test_arrays_of_a_frame_are_what_libraries_expect():
    frame = Frame(np.arange(12, dtype=np.uint8), 2, 2, by_name("RGB8"))
    assert np.asarray(frame).tolist() == frame.raw().tolist()
    assert np.asarray(frame, np.float32).dtype == np.float32
    assert frame.bgr().tolist() == frame.rgb()[..., ::-1].tolist()
    (part,) = frame.components
    assert np.array(part, np.uint16, copy=True).tolist() == frame.raw().tolist()
    assert part.bgr().tolist() == frame.bgr().tolist()


def test_the_kind_of_a_plain_image_follows_from_its_pixels():
    grey, distance = by_name("Mono8"), by_name("Coord3D_C16")
    assert Frame(np.zeros(4, np.uint8), 2, 2, grey).components[0].kind is ComponentKind.INTENSITY
    assert Frame(np.zeros(8, np.uint8), 2, 2, distance).components[0].kind is ComponentKind.RANGE


def test_a_monotonic_time_has_a_time_of_day():
    before = time.time_ns()
    found = time_of_day(time.monotonic_ns())
    assert before - 10**9 < found < time.time_ns() + 10**9
    assert time_of_day(10**12) - time_of_day(0) == pytest.approx(10**12, abs=10**9)


def test_a_component_as_a_frame_keeps_what_is_known_of_the_frame():
    grey = by_name("Mono8")
    part = Component(np.zeros(6, np.uint8), 3, 2, grey, ComponentKind.CONFIDENCE, offset_x=4, offset_y=5)
    frame = Frame(
        np.zeros(6, np.uint8), 3, 2, grey, frame_id=7, timestamp_ns=8, received_ns=9, captured=1.5,
        status=FrameStatus.INCOMPLETE, missing_bytes=2, chunks={"ChunkGain": 1.0}, stream_channel=1,
    )  # fmt: skip
    alone = frame.of_component(part)
    kept = ("frame_id", "timestamp_ns", "received_ns", "captured", "status", "missing_bytes", "chunks")
    for name in (*kept, "stream_channel"):
        assert getattr(alone, name) == getattr(frame, name), name
    assert (alone.width, alone.height, alone.offset_x, alone.offset_y) == (3, 2, 4, 5)
