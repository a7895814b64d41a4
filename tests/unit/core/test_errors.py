"""Errors that stand for others."""

import errno

import pytest

from grabbergui.core.errors import ResourceExhaustedError


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE, errno.ENOMEM])
def test_a_computer_that_has_nothing_left_is_not_the_peers_fault(number):
    error = ResourceExhaustedError.of(OSError(number, "x"))
    assert error is not None and str(error)


def test_other_causes_are_left_alone():
    assert ResourceExhaustedError.of(OSError(errno.ENOENT, "x")) is None
    assert ResourceExhaustedError.of(OSError("without a number")) is None
