"""Socket timeouts that expire although an interval timer interrupts the waiting."""

from __future__ import annotations

import select
import signal
import socket
import struct
import sys
import threading

# Python repeats a system call that a signal interrupted, and the kernel's timeout (SO_RCVTIMEO, SO_SNDTIMEO)
# starts again. With an interval timer of a shorter period (`signal.setitimer`, as profilers use it) it would
# never expire.
if sys.platform == "win32":

    def wait_readable(sock: socket.socket) -> int:
        """Return 0: Windows has no interval timers."""
        return 0

    wait_writable = wait_readable

else:
    _TIMEVAL = struct.Struct("@ll")

    def wait_readable(sock: socket.socket) -> int:
        """Wait until the socket is readable, or for its SO_RCVTIMEO, if a timer would interrupt `recv`.

        Returns flags for `recv`, which then does not wait. Returns 0 immediately if nothing interrupts it.
        """
        return _wait(sock, select.POLLIN, socket.SO_RCVTIMEO)

    def wait_writable(sock: socket.socket) -> int:
        """Wait in the same way for SO_SNDTIMEO; return flags for `send`."""
        return _wait(sock, select.POLLOUT, socket.SO_SNDTIMEO)

    def _wait(sock: socket.socket, event: int, option: int) -> int:
        if threading.get_ident() != threading.main_thread().ident:
            return 0  # only the main thread handles signals
        timers = (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)
        next_signal = min([left for timer in timers if (left := signal.getitimer(timer)[0])], default=0.0)
        if not next_signal:
            return 0
        seconds, microseconds = _TIMEVAL.unpack(sock.getsockopt(socket.SOL_SOCKET, option, _TIMEVAL.size))
        limit = seconds + microseconds / 1e6
        if limit <= next_signal:
            return 0
        poll = select.poll()
        poll.register(sock.fileno(), event)
        poll.poll(limit * 1000)  # after a signal, Python waits for the remaining time only
        return socket.MSG_DONTWAIT
