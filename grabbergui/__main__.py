"""The `grabbergui` command, also as `python -m grabbergui`."""

import signal
import sys


def main() -> int:
    """Run the command line; return its exit code.

    Until the command has been imported, Ctrl-C ends the program at once and quietly (130 in a shell): an
    exception would be a traceback out of whichever import was in progress.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # who ignores it means it
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.argv[1:2] == ["--complete"]:  # a shell asks while somebody types: without the commands' imports
        from grabbergui.setup.completion import main as complete

        return complete(sys.argv[2:])
    from grabbergui.cli import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
