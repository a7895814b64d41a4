"""The connection that gives way to a new one."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from grabbergui.net.yarp.os.connection_limits import (
    ADDRESS_LIMIT,
    CROWD,
    PORT_LIMIT,
    displaced,
    expendable,
)


def connections(address: str, count: int) -> list[Any]:
    """Return connections of one address, which have all carried a message, the second longest ago."""
    ages = [5.0, 1.0, *(9.0,) * count][:count]
    return [SimpleNamespace(address=address, messages=1, active=at) for at in ages]


def groups(sizes: Sequence[int]) -> list[Any]:
    return [each for number, size in enumerate(sizes) for each in connections(f"10.0.0.{number}", size)]


def test_an_address_at_its_limit_loses_its_longest_idle_connection() -> None:
    there = [*connections("10.0.0.2", 3), *connections("10.0.0.1", ADDRESS_LIMIT)]
    assert displaced(there, "10.0.0.1") is there[4]
    assert displaced(there[:-1], "10.0.0.1") is None
    assert displaced(there, "10.0.0.2") is None
    there[-1].messages = 0
    assert displaced(there, "10.0.0.1") is there[-1], "it never carried a message"


def test_a_full_port_closes_one_of_the_address_that_has_the_most() -> None:
    there = groups([40, 60, 50, PORT_LIMIT - 150])
    assert displaced(there, "10.0.1.1") is there[40 + 1]
    assert displaced(there[:-1], "10.0.1.1") is None
    assert displaced([], "10.0.1.1") is None


def test_descriptors_are_freed_only_where_an_address_has_a_crowd() -> None:
    there = groups([2, CROWD + 1, 1])
    assert expendable(there) is there[2 + 1]
    assert expendable(groups([CROWD, CROWD])) is None and expendable([]) is None


@pytest.mark.parametrize(
    ("carried", "closed"),
    [([(5, 1.0), (0, 9.0)], 1), ([(5, 2.0), (7, 1.0)], 1), ([(0, 2.0), (0, 3.0)], 0)],
    ids=["never used", "longest idle", "older"],
)
def test_a_connection_that_carried_nothing_goes_before_one_that_is_idle(
    carried: list[tuple[int, float]], closed: int
) -> None:
    there: list[Any] = [SimpleNamespace(address="a", messages=count, active=at) for count, at in carried * 5]
    assert expendable(there) is there[closed]
