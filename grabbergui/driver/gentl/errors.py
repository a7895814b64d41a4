"""A GenTL producer's exceptions as ours."""

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
"""Exceptions of producers for a camera that is gone."""

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
    """As `answering`; also turn a module that another application has open into AccessDeniedError."""
    try:
        yield
    except (gentl.AccessDeniedException, gentl.ResourceInUseException) as error:
        raise AccessDeniedError(
            f"{what}: the producer refuses because another application has it open: {reason_of(error)}"
        ) from error
    except gentl.GenericException as error:
        raise failure(what, error) from error


def failure(what: str, error: Exception) -> GrabberError:
    """Return our error for a producer's exception."""
    message = f"{what}: the producer answered: {reason_of(error)}"
    if isinstance(error, GONE):
        return DeviceLostError(message)
    if isinstance(error, gentl.TimeoutException):
        return AckTimeoutError(message)
    code = _CODE.search(str(error))
    return DeviceStatusError(message, int(code[1]) if code else int(gentl.GC_ERROR_LIST.GC_ERR_ERROR))


def reason_of(error: Exception) -> str:
    """Return the producer's own message, without the text that the binding adds."""
    text = str(error)
    match = _MESSAGE.search(text)
    return (match[1].strip() if match else "") or text
