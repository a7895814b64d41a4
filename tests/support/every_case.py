"""Many nearly equal cases as one test.

Collecting and reporting a test takes every worker milliseconds, such a case microseconds.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import pytest

LONGEST = 300
"Characters of a case, and of its error, that a failure shows."


def every_case(
    names: str | Sequence[str], values: Iterable[Any], ids: Callable[[Any], object] | None = None
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Replace `pytest.mark.parametrize`: run all cases in one test, which fails with all that failed.

    All cases share the test's fixtures. Use it for cases that leave nothing behind, and take little time.
    """
    wanted = [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)
    cases = [tuple(value) if len(wanted) > 1 else (value,) for value in values]
    assert cases, "there is no case"

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def run(**fixtures: Any) -> None:
            failed: list[tuple[str, BaseException]] = []
            for case in cases:
                try:
                    test(**dict(zip(wanted, case, strict=True)), **fixtures)
                except (Exception, pytest.fail.Exception) as error:
                    failed.append((", ".join(_named(value, ids) for value in case), error))
                except pytest.skip.Exception as error:
                    raise AssertionError("one case of several cannot be skipped") from error
            if failed:
                lines = [f"[{case}] {type(error).__name__}: {_short(error)}" for case, error in failed]
                count = f"{len(failed)} of {len(cases)} cases fail:"
                raise AssertionError("\n".join((count, *lines))) from failed[0][1]

        parameters = inspect.signature(test).parameters.values()
        run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [parameter for parameter in parameters if parameter.name not in wanted]
        )
        return run

    return decorate


def _named(value: object, ids: Callable[[Any], object] | None) -> str:
    return _short(value if ids is None else ids(value), repr if ids is None else str)


def _short(value: object, text: Callable[[object], str] = str) -> str:
    whole = text(value)
    return whole if len(whole) <= LONGEST else f"{whole[:LONGEST]}…"
