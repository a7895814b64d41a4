"""Our host on the kernel's virtual video device, beside v4l2-ctl, in a virtual machine."""

from __future__ import annotations

from typing import Any

import pytest

from guest import GUEST_SECONDS, Guest

pytestmark = [pytest.mark.usb, pytest.mark.timeout(GUEST_SECONDS + 200)]


@pytest.fixture(scope="module")
def seen(guest: Guest) -> dict[str, Any]:
    result: dict[str, Any] = guest.result()["webcam"]
    assert "failure" not in result, result
    return result


def test_the_device_is_found(seen: dict[str, Any]) -> None:
    info = seen["info"]
    assert (info["uri"], info["model"], info["bus"]) == ("v4l2:/dev/video0", "vivid", "V4L2")


@pytest.mark.parametrize(("name", "shape"), [("YUV422_8", [2]), ("BGR8", [3]), ("Mono8", []), ("Mono16", [])])
def test_frames_arrive_in_each_format(seen: dict[str, Any], name: str, shape: list[int]) -> None:
    frames = seen["formats"][name]
    assert frames["shape"] == [360, 640, *shape]
    assert frames["ids"] == sorted(set(frames["ids"]))
    assert 20 < frames["brightness"] < 200 and frames["contrast"] > 20  # vivid sends colour bars


def test_v4l2_ctl_and_we_see_the_same_values(seen: dict[str, Any]) -> None:
    if seen["brightness by v4l2-ctl"] is None:
        pytest.skip("no v4l2-ctl here (Debian: v4l-utils)")
    assert seen["brightness by v4l2-ctl"].strip() == "brightness: 77"
    assert seen["brightness by us"] == 99
    assert "320/180" in seen["format by v4l2-ctl"] and "5.000" in seen["format by v4l2-ctl"]


def test_a_second_program_learns_that_it_is_busy(seen: dict[str, Any]) -> None:
    assert seen["another program"].startswith("AccessDeniedError: /dev/video0: another program streams")


def test_a_device_that_goes_is_noticed(seen: dict[str, Any]) -> None:
    assert seen["lost"] == "lost: /dev/video0 was unplugged"
