"""The one tree of errors.

A message names the thing, the value, what is allowed and what to do next; the command line prints it as
it is and the window shows it in its bar. Exceptions of other libraries become one of these in the file
that calls them.
"""

from __future__ import annotations

import errno


class GrabberError(Exception):
    """Base of all errors that a user may see."""


class UsageError(GrabberError):
    """A request that makes no sense: a malformed URI, a value that is not NAME=VALUE."""


class MissingFileError(UsageError):
    """A file or folder that was named does not exist."""


class SourceNotFoundError(GrabberError):
    """No camera or remote port answers to the URI."""


class OtherCameraError(SourceNotFoundError):
    """Another camera answers than the one that was named or lost, or several answer to one name."""


class SourceUnavailableError(GrabberError):
    """The URI's kind of source needs something that this machine lacks (a package, a server)."""


class ProtocolError(GrabberError):
    """A message broke its protocol's rules."""


class LocalProtocolError(ProtocolError):
    """We asked a codec for something illegal: a bug of ours."""


class RemoteProtocolError(ProtocolError):
    """The peer sent something illegal; nothing of it was used."""


class DeviceStatusError(GrabberError):
    """The device answered with an error status."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status
        "The GVCP or GenCP status code as received."


class TransportError(GrabberError):
    """Bytes could not be moved between us and the device."""


class AckTimeoutError(TransportError):
    """The device did not acknowledge, all retries spent."""


_EXHAUSTED = {
    errno.EMFILE: "this program has as many files and connections open as it may (`ulimit -n`)",
    errno.ENFILE: "this machine has as many files and connections open as it can (`sysctl fs.file-max`)",
    errno.ENOBUFS: "this machine has no memory left for connections",
    errno.ENOMEM: "this machine has no memory left for connections",
}


class ResourceExhaustedError(TransportError):
    """Descriptors, threads or memory of this process or machine are used up; no peer is to blame."""

    @classmethod
    def of(cls, error: OSError) -> ResourceExhaustedError | None:
        """Return what to raise in place of `error`; None where that has another cause."""
        text = _EXHAUSTED.get(error.errno or 0)
        return cls(text) if text else None


class DeviceLostError(TransportError):
    """The device is gone, or took our control away."""


class AccessDeniedError(GrabberError):
    """Another application holds control of the device, or the system refuses us access to it."""


class FeatureError(GrabberError):
    """Something about one feature."""

    def __init__(self, message: str, feature: str) -> None:
        super().__init__(message)
        self.feature = feature
        "The feature's name."


class FeatureNotFoundError(FeatureError):
    """The source has no feature of this name."""


class FeatureAccessError(FeatureError):
    """The feature is not implemented, not available, locked, read-only or write-only at the moment."""


class FeatureValueError(FeatureError):
    """The value is out of range, off the increment, not among the entries, or of the wrong type."""


class CameraFileError(GrabberError):
    """A camera refused an operation on one of its files."""

    def __init__(self, message: str, file: str, operation: str = "", status: str = "") -> None:
        super().__init__(message)
        self.file = file
        "As FileSelector has it."
        self.operation = operation
        "Open, Close, Read, Write or Delete; empty if it did not come to one."
        self.status = status
        "FileOperationStatus as the camera reports it."


class TransferCancelledError(CameraFileError):
    """A transfer of a file was cancelled; an upload leaves the file incomplete."""


class PixelFormatError(GrabberError):
    """A payload's pixel format cannot be converted; its raw bytes can still be saved."""


class FrameTimeoutError(GrabberError):
    """No frame arrived in time."""
