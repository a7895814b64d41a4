"""The loops that numba compiles on import; imported by `fast_path` only. Linux, 64 bits, little-endian.

They call the C library, and so wait for packets, read and store them without Python and its lock.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy as np

from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import FLAG_RESEND, IP_UDP_BYTES, PacketHeader
from grabbergui.driver.gige.stream.fast_path import (
    BLOCK_ID,
    EMPTY,
    END,
    ENDED,
    FAILED,
    GAP_AT,
    GAPS,
    HEADER,
    HIGHEST,
    KIND,
    LAST,
    LATE,
    LONGEST,
    LOOKED,
    MISSING,
    MORE,
    MOST_NOTED,
    NOTED,
    NOW,
    OTHER,
    PATIENCE,
    PERIOD,
    SOURCES,
    STRIDE,
    TAKEN,
    TOP,
    Lane,
)
from grabbergui.driver.gige.stream.packet_ring import (
    AT,
    IP_AT,
    IP_KIND,
    IP_PLAIN,
    OURS,
    PAYLOAD_AT,
    SLOT_BYTES,
    RingView,
)
from grabbergui.driver.gige.stream.recvmmsg import (
    CONTROL,
    CONTROL_LENGTH,
    DEVICE,
    DONT_WAIT,
    JOINED,
    LENGTH,
    MOST,
    OFFSET,
    PITCH,
    RECEIVED,
    SLOT,
    SOCKET,
    SOURCE,
    SlotsView,
)

_Function = TypeVar("_Function", bound=Callable[..., Any])
_IMPORTED = ("fast_path.py", "packet_ring.py", "recvmmsg.py")
"Files with constants that are compiled in."
types: Any = numba.types
_EXTENDED = PacketHeader.EXTENDED.size
_RESENT = np.uint64(Status.PACKET_RESEND << 48)
_EXTENDED_RESENT = np.uint64(Status.PACKET_RESEND << 48 | FLAG_RESEND << 32)
_CONTROL_BYTES = CONTROL.itemsize
_READS, _PACKETS = 64, 8192
"Reads of a socket, and packets of a ring, before timers have their turn."
_IDLE = 64
"Waits after which nothing could be read: an error, if they do not last."
_NEAR, _SHORTEST = 0.001, 0.0005
"Seconds before a block's end in which each packet is awaited; a shorter pause before that is not worth it."
_MONOTONIC = 1
"Linux's CLOCK_MONOTONIC, which `time.monotonic` reads."

_recvmmsg = types.ExternalFunction(
    "recvmmsg", types.intc(types.intc, types.uintp, types.uintc, types.intc, types.uintp)
)
_ppoll = types.ExternalFunction("ppoll", types.intc(types.uintp, types.uintp, types.uintp, types.uintp))
_recv = types.ExternalFunction("recv", types.intp(types.intc, types.uintp, types.uintp, types.intc))
_clock_gettime = types.ExternalFunction("clock_gettime", types.intc(types.intc, types.uintp))
_memcpy = types.ExternalFunction("memcpy", types.uintp(types.uintp, types.uintp, types.uintp))


def _row(kind: Any) -> Any:
    return types.Array(kind, 1, "C")


def _rows(kind: Any) -> Any:
    return types.Array(kind, 2, "C")


def _tuple(kind: type, **fields: Any) -> Any:
    return types.NamedTuple([fields[name] for name in kind._fields], kind)  # type: ignore[attr-defined]


_I64, _F64, _U8 = _row(types.int64), _row(types.float64), _row(types.uint8)
_LANE = _tuple(
    Lane,
    state=_I64,
    times=_F64,
    received=_U8,
    buffer=_U8,
    noted_ids=_I64,
    noted_at=_F64,
    noted_resent=_U8,
    clock=_I64,
)
_SLOTS = _tuple(
    SlotsView,
    data=_U8,
    messages=_rows(types.uint64),
    control=_rows(types.uint64),
    sources=_rows(types.uint32),
    cursor=_I64,
)
_RING = _tuple(RingView, data=_U8, words=_rows(types.uint32), cursor=_I64)
_LAYOUT = zlib.crc32(b"".join(Path(__file__).with_name(name).read_bytes() for name in _IMPORTED))


def _compiled(loop: _Function, signature: Any = None) -> _Function:
    """Compile a function when it is first called, or at once for a signature; its results are kept on disk.

    numba forgets kept results when this file changes. The constants that others define are in the name.
    """
    loop.__qualname__ += f"_{_LAYOUT:08x}"
    compiled: _Function = numba.njit(signature, nogil=True, cache=True)(loop)
    return compiled


def _loop(source: Any) -> Callable[[_Function], _Function]:
    """Compile a loop that Python calls: with the lane, what is read, polls, until, patient."""
    signature = types.int64(_LANE, source, _I64, types.float64, types.boolean)
    return partial(_compiled, signature=signature)


@_compiled
def _now(lane: Any) -> Any:
    _clock_gettime(_MONOTONIC, lane.clock.ctypes.data)
    return lane.clock[0] + 1e-9 * lane.clock[1]


@_compiled
def _number(data: Any, at: Any, size: Any) -> Any:
    """Return the big-endian number at a place; LLVM makes one load of it."""
    number = np.uint64(0)
    for i in range(size):
        number = number << np.uint64(8) | np.uint64(data[at + i])
    return number


@_compiled
def _store(lane: Any, data: Any, at: Any) -> Any:
    """Store a packet of full length; return False, and do nothing, if it is not a new one of the block."""
    state = lane.state
    word = _number(data, at, 8)
    if state[HEADER] == _EXTENDED:
        resent = word & _EXTENDED_RESENT
        if np.int64(_number(data, at + 8, 8)) != state[BLOCK_ID]:
            return False
        packet_id = np.int64(_number(data, at + 16, 4))
    else:
        resent = word & _RESENT
        packet_id = np.int64(word & np.uint64(0xFFFFFF))
    if np.int64((word ^ resent) >> np.uint64(24)) != state[KIND]:
        return False
    if packet_id < 1 or packet_id > state[LAST] or lane.received[packet_id]:
        return False
    if packet_id < state[HIGHEST] or resent:
        if state[NOTED] == MOST_NOTED:
            return False
        lane.noted_ids[state[NOTED]] = packet_id
        lane.noted_at[state[NOTED]] = lane.times[NOW]
        lane.noted_resent[state[NOTED]] = resent != 0
        state[NOTED] += 1
    if packet_id > state[HIGHEST] + 1 and not state[GAPS]:
        state[GAPS] = 1
        lane.times[GAP_AT] = lane.times[NOW]
    if lane.buffer.size:
        stride = state[STRIDE]
        to = lane.buffer.ctypes.data + (packet_id - 1) * stride
        _memcpy(to, data.ctypes.data + at + state[HEADER], stride)
    lane.received[packet_id] = 1
    state[TAKEN] += 1
    state[MISSING] -= 1
    state[TOP] = max(state[TOP], packet_id)
    state[HIGHEST] = max(state[HIGHEST], packet_id)
    return True


@_compiled
def _ended(state: Any) -> Any:
    """Return whether the packet stored last ends the block."""
    return state[MISSING] == 0 or state[TOP] == state[LAST]


@_compiled
def _poll(lane: Any, polls: Any, count: Any, seconds: Any) -> Any:
    """Wait for one of the sockets at an address; return whether one can be read."""
    lane.clock[0] = np.int64(seconds)
    lane.clock[1] = np.int64(1e9 * (seconds - lane.clock[0]))
    return _ppoll(polls, count, lane.clock.ctypes.data, 0) > 0


@_compiled
def _wait(lane: Any, polls: Any, until: Any, patient: Any) -> Any:
    """Wait for a packet, or let packets gather far from the block's end; return EMPTY if there is no time.

    A socket in `polls` behind those that packets come from ends a pause: it shows that the block ended.
    """
    state, times = lane.state, lane.times
    if state[STRIDE] < 0 and not patient:
        return EMPTY
    now = _now(lane)
    if state[GAPS]:
        until = min(until, times[GAP_AT] + times[PATIENCE])
    wait = until - now
    if wait <= 0.0:
        return EMPTY
    remaining = (state[END] - state[HIGHEST]) * times[PERIOD] - (now - times[NOW])
    pause = min(remaining - _NEAR, times[LONGEST])
    sources = state[SOURCES]
    if patient or pause < _SHORTEST:
        return MORE if _poll(lane, polls.ctypes.data, sources, wait) else EMPTY
    pause = min(pause, wait)
    enders = polls.size - sources
    if _poll(lane, polls.ctypes.data + 8 * sources, enders, pause):
        while _recv(polls[sources] & 0xFFFFFFFF, 0, 0, DONT_WAIT) >= 0:
            pass
    times[LATE] = max(times[LATE], _now(lane) - now - pause)
    return MORE


# -- recvmmsg ------------------------------------------------------------------------------------------
@_compiled
def _read(lane: Any, slots: Any, polls: Any) -> Any:
    """Read from the first socket, counted from the newest, that has datagrams; return whether one has."""
    cursor = slots.cursor
    for _ in range(lane.state[SOURCES]):
        for slot in range(cursor[MOST]):
            slots.messages[slot, CONTROL_LENGTH] = _CONTROL_BYTES
        descriptor = polls[cursor[SOCKET]] & 0xFFFFFFFF
        got = _recvmmsg(descriptor, slots.messages.ctypes.data, cursor[MOST], DONT_WAIT, 0)
        cursor[SLOT] = cursor[OFFSET] = 0
        cursor[RECEIVED] = max(got, 0)
        if got > 0:
            return True
        cursor[SOCKET] = (cursor[SOCKET] + 1) % lane.state[SOURCES]
    return False


@_compiled
def _take_slots(lane: Any, slots: Any) -> Any:
    """Store what was read; return MORE if all of it was."""
    cursor = slots.cursor
    while cursor[SLOT] < cursor[RECEIVED]:
        slot = cursor[SLOT]
        length = np.int64(slots.messages[slot, LENGTH] & np.uint64(0xFFFFFFFF))
        packet = length
        if slots.messages[slot, CONTROL_LENGTH]:
            packet = np.int64(slots.control[slot, JOINED] & np.uint64(0xFFFFFFFF))
        full = lane.state[HEADER] + lane.state[STRIDE]
        if slots.sources[slot, SOURCE] != cursor[DEVICE] or length > cursor[PITCH] or packet != full:
            return OTHER
        while cursor[OFFSET] < length:
            at = slot * cursor[PITCH] + cursor[OFFSET]
            if length - cursor[OFFSET] < full or not _store(lane, slots.data, at):
                return OTHER
            cursor[OFFSET] += full
            if cursor[OFFSET] == length:
                break
            if _ended(lane.state):
                return ENDED
        cursor[SLOT] += 1
        cursor[OFFSET] = 0
        if _ended(lane.state):
            return ENDED
    return MORE


@_loop(_SLOTS)
def take_datagrams(lane: Any, slots: Any, polls: Any, until: Any, patient: Any) -> Any:
    """Read and store packets until something else happens, or nothing did until the time `until`.

    The slots' cursor then points to the packet that is not stored. `patient`: wait for the first packet.
    """
    reads = idle = 0
    while idle < _IDLE:
        outcome = _take_slots(lane, slots)
        if outcome != MORE or reads == _READS:
            return outcome
        got = _read(lane, slots, polls)
        lane.times[LOOKED] = _now(lane)
        if got:
            lane.times[NOW] = lane.times[LOOKED]
            reads, idle, patient = reads + 1, 0, False
        elif _wait(lane, polls, until, patient) == EMPTY:
            return EMPTY
        else:
            idle += 1
    return FAILED


# -- a packet ring ---------------------------------------------------------------------------------------
@_loop(_RING)
def take_ring(lane: Any, ring: Any, polls: Any, until: Any, patient: Any) -> Any:
    """Store packets of a ring until something else happens, or nothing did until the time `until`.

    The ring's cursor then points to the packet that is not stored. `patient`: wait for the first packet.
    """
    cursor, words = ring.cursor, ring.words
    full = lane.state[HEADER] + lane.state[STRIDE]
    lane.times[LOOKED] = _now(lane)
    while True:
        slot = cursor[AT]
        if not words[slot, 0] & OURS:
            if _wait(lane, polls, until, patient) == EMPTY:
                return EMPTY
            lane.times[LOOKED] = _now(lane)
            continue
        lane.times[NOW] = lane.times[LOOKED]
        at = slot * cursor[SLOT_BYTES]
        length = _number(ring.data, at + IP_AT + 2, 2) - np.uint64(IP_UDP_BYTES)
        plain = _number(ring.data, at + IP_AT, 8) & IP_KIND == IP_PLAIN
        whole = words[slot, 2] >= words[slot, 1] and words[slot, 3] >> np.uint32(16) == IP_AT
        if not plain or not whole or length != full or not _store(lane, ring.data, at + PAYLOAD_AT):
            return OTHER
        words[slot, 0] = 0
        patient = False
        cursor[AT] = slot + 1 if slot + 1 < words.shape[0] else 0
        if _ended(lane.state):
            return ENDED
        if lane.state[TAKEN] == _PACKETS:
            return MORE
