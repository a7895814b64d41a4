"""GenTL's exceptions as ours."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from genicam import gentl

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
)

GONE = (gentl.IoException, gentl.InvalidHandleException, gentl.ClosedException, gentl.NotInitializedException)
"""What producers answer once the camera behind a handle is away."""

_CODE = re.compile(r"\(ID: (-?\d+)\)")
_MESSAGE = re.compile(r"Message from the source: (.*?)\)? \(ID:", re.DOTALL)


@contextmanager
def answering(what: str) -> Iterator[None]:
    """Turn a producer's refusal of `what` into DeviceLostError, AckTimeoutError or DeviceStatusError."""
    try:
        yield
    except gentl.GenericException as error:
        raise failure(what, error) from error


@contextmanager
def opening(what: str) -> Iterator[None]:
    """As `answering`, and a module that somebody else has open gives AccessDeniedError."""
    try:
        yield
    except (gentl.AccessDeniedException, gentl.ResourceInUseException) as error:
        raise AccessDeniedError(
            f"{what}: the producer refuses, as another application has it open: {reason_of(error)}"
        ) from error
    except gentl.GenericException as error:
        raise failure(what, error) from error


def failure(what: str, error: Exception) -> GrabberError:
    """Our word for a producer's exception."""
    message = f"{what}: the producer answered: {reason_of(error)}"
    if isinstance(error, GONE):
        return DeviceLostError(message)
    if isinstance(error, gentl.TimeoutException):
        return AckTimeoutError(message)
    code = _CODE.search(str(error))
    return DeviceStatusError(message, int(code[1]) if code else int(gentl.GC_ERROR_LIST.GC_ERR_ERROR))


def reason_of(error: Exception) -> str:
    """The producer's own message, without the binding's frame around it."""
    text = str(error)
    match = _MESSAGE.search(text)
    return (match[1].strip() if match else "") or text
