"""All errors of the program, in one tree.

A message names the object, the value, the allowed values and what to do next; the command line prints it
unchanged, and the window shows it in its bar. The file that calls another library turns its exceptions into
one of these.

Where Python has an exception for the same thing, an error is one, too (`TimeoutError`, `ValueError`,
`KeyError`, `PermissionError`, `FileNotFoundError`), so that programs may catch what they catch elsewhere.
Code here that catches one of those, or `OSError`, around calls that raise these must let GrabberError pass
first.
"""

from __future__ import annotations

import errno
from pathlib import Path

_EXHAUSTED = {
    errno.EMFILE: "this program has as many files and connections open as it may (`ulimit -n`)",
    errno.ENFILE: "this computer has as many files and connections open as it can (`sysctl fs.file-max`)",
    errno.ENOBUFS: "this computer has no memory left for connections",
    errno.ENOMEM: "this computer has no memory left for connections",
}


class GrabberError(Exception):
    """Base of all errors that a user may see."""


class UsageError(GrabberError, ValueError):
    """An invalid request, such as a malformed URI or an assignment that is not NAME=VALUE."""


class MissingFileError(UsageError, FileNotFoundError):
    """The named file or folder does not exist."""


class ExistingFileError(UsageError, FileExistsError):
    """The named file or folder exists, and is not overwritten."""


class LocalFileError(GrabberError, OSError):
    """A file on this computer could not be read or written."""

    @classmethod
    def of(cls, path: Path, done: str, error: OSError) -> LocalFileError:
        """Return the error to raise instead of `error`; `done` is `read` or `written`."""
        return cls(f"{path} could not be {done}: {error.strerror or error}")


class SourceNotFoundError(GrabberError, LookupError):
    """No camera or remote port answers to the URI."""


class OtherCameraError(SourceNotFoundError):
    """Another camera than the named or lost one answers, or several cameras have the same name."""


class SourceUnavailableError(GrabberError):
    """The URI's kind of source needs something that this computer lacks (a package, a server)."""


class NoNameServerError(SourceUnavailableError):
    """No YARP name server answers; one can be started."""

    where = ""
    "Its HOST:PORT."


class ProtocolError(GrabberError):
    """A message broke its protocol's rules."""


class LocalProtocolError(ProtocolError):
    """The program asked a codec for something illegal, which is a bug."""


class RemoteProtocolError(ProtocolError):
    """The peer sent an illegal message, of which nothing was used."""


class DeviceStatusError(GrabberError):
    """The device answered with an error status."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status
        "The GVCP or GenCP status code as received."


class TransportError(GrabberError):
    """Bytes could not be transferred to or from the device."""


class AckTimeoutError(TransportError):
    """The device acknowledged neither the request nor its retries."""

    addresses: frozenset[str] = frozenset()
    "The devices that did not acknowledge, if several were asked."
    postponed = False
    "Whether the device had asked for more time."


class ResourceExhaustedError(TransportError):
    """The process or computer has no descriptors, threads or memory left; the peer is not at fault."""

    @classmethod
    def of(cls, error: OSError) -> ResourceExhaustedError | None:
        """Return the error to raise instead of `error`; None if that has another cause."""
        text = _EXHAUSTED.get(error.errno or 0)
        return cls(text) if text else None


class DeviceLostError(TransportError):
    """The device has disappeared, or no longer grants control."""


class AccessDeniedError(GrabberError, PermissionError):
    """Another application holds control of the device, or the system refuses access to it."""


class FeatureError(GrabberError):
    """An error that concerns one feature."""

    def __init__(self, message: str, feature: str) -> None:
        super().__init__(message)
        self.feature = feature
        "The feature's name."


class FeatureNotFoundError(FeatureError, KeyError):
    """The source has no feature of this name."""

    __str__ = Exception.__str__  # KeyError's puts the message into quotation marks


class FeatureAccessError(FeatureError):
    """The feature is currently not implemented, not available, locked, read-only or write-only."""


class FeatureValueError(FeatureError, ValueError):
    """The value is out of range, off the increment, not among the entries, or of the wrong type."""


class CalibrationError(GrabberError):
    """The images or poses that were taken do not determine a calibration."""


class CameraFileError(GrabberError):
    """A camera refused an operation on one of its files."""

    def __init__(self, message: str, file: str, operation: str = "", status: str = "") -> None:
        super().__init__(message)
        self.file = file
        "Its entry of FileSelector."
        self.operation = operation
        "Open, Close, Read, Write or Delete; empty if the error came before any."
        self.status = status
        "FileOperationStatus as reported by the camera."


class TransferCancelledError(CameraFileError):
    """The transfer of a file was cancelled; a cancelled upload leaves the file incomplete."""


class MissingFrameError(GrabberError, KeyError):
    """A set of frames has none of this camera."""

    __str__ = Exception.__str__  # KeyError's puts the message into quotation marks


class PixelFormatError(GrabberError, ValueError):
    """The payload's pixel format cannot be converted; the raw bytes can still be saved."""


class FrameTimeoutError(GrabberError, TimeoutError):
    """No frame arrived in time."""


class StreamEndedError(FrameTimeoutError):
    """No frame arrives any more, as the stream has an end: a recording was played to its last frame."""


class ClosedError(GrabberError, ValueError):
    """The camera was closed by this program; open it again to use it.

    A ValueError, as Python raises for a closed file.
    """
