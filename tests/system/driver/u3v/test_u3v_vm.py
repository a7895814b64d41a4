"""Our host and our simulated camera on a real USB stack, beside Aravis, in a virtual machine.

One boot serves all tests here, which come last; what happens in the guest is in `in_guest.py`.
"""

from __future__ import annotations

from typing import Any

import pytest

from guest import GUEST_SECONDS, Guest
from in_guest import ENOUGH_FRAMES, FRAMES, HEIGHT, WIDTH

pytestmark = [pytest.mark.usb, pytest.mark.timeout(GUEST_SECONDS + 200)]


@pytest.fixture(scope="module")
def seen(guest: Guest) -> dict[str, Any]:
    """Results of the hosts in the guest, by the way in which the camera is a USB device there."""
    return guest.result()


@pytest.fixture(params=["vhci", "gadget"])
def way(request: pytest.FixtureRequest, seen: dict[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = seen[request.param]
    return result


@pytest.fixture
def with_aravis(way: dict[str, Any]) -> dict[str, Any]:
    if "aravis" not in way and "failure" not in way:
        pytest.skip("no arv-tool-0.8 here (Debian: aravis-tools-cli)")
    return way


def test_nothing_failed_in_the_guest(way: dict[str, Any]) -> None:
    assert "failure" not in way, way


def test_our_host_lists_the_camera_by_its_serial(way: dict[str, Any]) -> None:
    (listed,) = way["listed"]
    assert listed["uri"] == "u3v:SIM001"
    assert listed["interface"].endswith("SuperSpeed")


def test_our_host_receives_every_frame_twice_in_a_row(way: dict[str, Any]) -> None:
    assert way["good_frames"] == [FRAMES, FRAMES]
    statistics = way["statistics"]
    assert (statistics["incomplete"], statistics["lost"], statistics["packets_missing"]) == (0, 0, 0)


def test_a_program_that_ends_while_streaming_ends_cleanly(way: dict[str, Any]) -> None:
    assert way["forgetful_exit"] == 0


def test_viva_lists_the_camera_and_reads_it(way: dict[str, Any]) -> None:
    if "viva" not in way:
        pytest.skip("no viva-camctl here")
    assert "SuperSpeed (5 Gbit/s)" in way["viva"]
    assert way["viva"].rstrip().endswith(str(WIDTH * HEIGHT))


def test_aravis_lists_the_camera_by_its_guid(with_aravis: dict[str, Any]) -> None:
    assert "grabbergui-GRUI00SIM001-SIM001 (USB3)" in with_aravis["aravis_list"]


def test_what_one_host_sets_the_other_reads(with_aravis: dict[str, Any]) -> None:
    assert "ExposureTime = 3000 us" in with_aravis["aravis_set"]
    assert with_aravis["exposure_set_by_aravis"] == 3000.0
    assert "ExposureTime = 4000 us" in with_aravis["aravis_reads"]


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_aravis_streams_without_a_failure(with_aravis: dict[str, Any], mode: str) -> None:
    counters = with_aravis["aravis"][mode]
    assert counters["n_completed_buffers"] >= ENOUGH_FRAMES
    assert counters["n_failures"] == 0
    assert counters["n_ignored_bytes"] == 0


def test_unplugging_is_reported_once(seen: dict[str, Any]) -> None:
    unplugged = seen["vhci"]["unplugged"]
    assert len(unplugged["reported"]) == 1
    assert "unplugged" in unplugged["reported"][0]
    assert unplugged["refused"] == "DeviceLostError"


def test_a_killed_camera_makes_room_for_the_next_on_its_controller(seen: dict[str, Any]) -> None:
    assert seen["gadget"].get("replaced"), seen["gadget"]
