"""One test of many cases: all of them run, and a failure names each that failed."""

import re

import pytest

from every_case import every_case


def test_a_failure_names_each_case_that_failed():
    seen = []

    @every_case("number, limit", [(1, 2), (5, 2), (2, 3), (9, 4)])
    def check(number, limit):
        seen.append(number)
        assert number <= limit

    expected = r"2 of 4 cases fail:\n\[5, 2\] AssertionError: assert 5 <= 2\n\[9, 4\] AssertionError"
    with pytest.raises(AssertionError, match=expected):
        check()
    assert seen == [1, 5, 2, 9]


def test_an_error_that_is_not_raised_is_a_failure():
    @every_case("text", ["1", "x", "2"], ids=lambda text: f"text {text}")
    def check(text):
        with pytest.raises(ValueError):
            int(text)

    with pytest.raises(AssertionError, match=re.escape("2 of 3 cases fail:\n[text 1] Failed")):
        check()


def test_a_skip_does_not_hide_the_other_cases():
    @every_case("number", [1, 2])
    def check(number):
        pytest.skip("no")

    with pytest.raises(AssertionError, match="cannot be skipped"):
        check()


@every_case("first", [1, 2])
@every_case("second", [3, 4])
def test_cases_are_combined_and_take_fixtures(tmp_path, first, second):
    (tmp_path / f"{first}{second}").touch()
    if (first, second) == (2, 4):
        assert {path.name for path in tmp_path.iterdir()} == {"13", "14", "23", "24"}
