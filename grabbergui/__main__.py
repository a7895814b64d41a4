"""The `grabbergui` command, also as `python -m grabbergui`."""

import atexit
import gc
import os
import signal
import sys
import threading


def main() -> int:
    """Run the command line; return its exit code.

    Until the command has been imported, Ctrl-C ends the program at once and quietly (130 in a shell): an
    exception would be a traceback out of whichever import was in progress.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # who ignores it means it
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    _open_standard_streams()
    # At its end, Python searches everything for garbage several times: after a window, for more than a second
    # on a busy machine.
    atexit.register(gc.freeze)
    # The matrices here are small, and OpenBLAS's threads spin while they wait for each other: they would take
    # three times as long. A program that imports the package keeps the threads that it has.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # OpenCV's messages about a damaged image would precede ours on stderr.
    os.environ.setdefault("OPENCV_LOG_LEVEL", "FATAL")
    if sys.argv[1:2] == ["--complete"]:  # a shell asks while somebody types: without the commands' imports
        from grabbergui.setup.completion import main as complete

        return complete(sys.argv[2:])
    from grabbergui.core.visible_text import print_traceback

    sys.excepthook = print_traceback
    threading.excepthook = lambda uncaught: print_traceback(
        uncaught.exc_type, uncaught.exc_value, uncaught.exc_traceback
    )
    from grabbergui.cli import main as run

    return run()


def _open_standard_streams() -> None:
    """Open what our parent closed of stdin, stdout and stderr (`2>&-`), to nowhere.

    Otherwise the next file to be opened, perhaps a recording, takes its number, and C libraries write their
    messages into it. Python would print ours on stdout.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
            os.set_inheritable(opened, True)
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115  # until the program ends


if __name__ == "__main__":
    sys.exit(main())
