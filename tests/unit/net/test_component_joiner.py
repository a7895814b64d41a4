"""Components that come one by one join the image of the same stamp, which they never hold up long."""

from __future__ import annotations

import numpy as np
import pytest

from grabbergui.core.component import ComponentKind
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.net.component_joiner import MOST_COMPONENTS, MOST_WAITING, WAIT, ComponentJoiner, kind_of


def image(stamp: int, pixel_format: str = "Mono8") -> Frame:
    size = 8 if pixel_format == "Mono8" else 16
    return Frame(np.zeros(size, np.uint8), 4, 2, by_name(pixel_format), stamp, timestamp_ns=stamp)


def kinds(frame: Frame) -> list[str]:
    return [part.name for part in frame.parts]


def stamps(frames: list[Frame]) -> list[int]:
    return [frame.timestamp_ns for frame in frames]


@pytest.fixture
def joiner() -> ComponentJoiner:
    """One that has seen a range that came in time."""
    joiner = ComponentJoiner()
    assert stamps(joiner.image(image(1), 0.0)) == [1]
    assert joiner.component("range", image(1), 0.01) == []
    assert joiner.late == 1
    return joiner


def test_the_first_image_waits_for_nothing_and_the_next_for_what_came(joiner: ComponentJoiner) -> None:
    assert joiner.image(image(2), 1.0) == []
    assert joiner.deadline == pytest.approx(1.0 + WAIT)
    (frame,) = joiner.component("range", image(2, "Coord3D_C16"), 1.01)
    assert kinds(frame) == ["intensity", "range"]
    assert frame.components[1].pixel_format.name == "Coord3D_C16" and frame.timestamp_ns == 2


def test_a_component_may_come_before_its_image(joiner: ComponentJoiner) -> None:
    assert joiner.component("range", image(2), 1.0) == []
    (frame,) = joiner.image(image(2), 1.01)
    assert kinds(frame) == ["intensity", "range"]


def test_a_component_without_a_stamp_joins_no_image() -> None:
    joiner = ComponentJoiner()
    assert joiner.component("range", image(0), 0.0) == []
    (frame,) = joiner.image(image(0), 0.5)
    assert kinds(frame) == []
    assert joiner.component("range", image(0), 0.51) == [] and joiner.late == 0


def test_a_component_that_is_silent_holds_up_one_image_for_the_time_allowed(joiner: ComponentJoiner) -> None:
    assert joiner.image(image(2), 1.0) == []
    assert joiner.due(1.0 + WAIT / 2) == []
    assert stamps(joiner.due(1.0 + WAIT)) == [2]
    assert stamps(joiner.image(image(3), 1.2)) == [3] and joiner.deadline is None


def test_a_component_that_is_always_too_late_is_not_waited_for(joiner: ComponentJoiner) -> None:
    joiner.image(image(2), 1.0)
    joiner.due(1.0 + WAIT)
    assert joiner.component("range", image(2), 1.0 + 2 * WAIT) == []
    assert stamps(joiner.image(image(3), 2.0)) == [3]
    assert joiner.component("range", image(3), 2.0 + WAIT / 2) == []  # in time again
    assert joiner.image(image(4), 3.0) == []


def test_a_later_image_of_a_component_shows_that_its_own_was_lost(joiner: ComponentJoiner) -> None:
    assert joiner.image(image(2), 1.0) == []
    assert joiner.image(image(3), 1.02) == []
    first, second = joiner.component("range", image(3), 1.03)
    assert (kinds(first), kinds(second)) == ([], ["intensity", "range"])
    joiner.component("range", image(5), 1.04)
    assert stamps(joiner.image(image(4), 1.05)) == [4]


def test_after_a_clock_was_set_back_images_wait_for_their_components_again(joiner: ComponentJoiner) -> None:
    """As of a recording that begins again. The image of the last component did not come any more."""
    assert joiner.component("range", image(60_000_000_000), 1.0) == []
    for count in range(2, 2 + 3 * MOST_WAITING):
        assert joiner.image(image(count), float(count)) == []
        (frame,) = joiner.component("range", image(count), count + 0.01)
        assert kinds(frame) == ["intensity", "range"]


def test_images_leave_in_their_order(joiner: ComponentJoiner) -> None:
    joiner.image(image(2), 1.0)
    joiner.component("confidence", image(2), 1.0)
    joiner.component("range", image(2), 1.0)
    assert joiner.image(image(3), 1.1) == [] and joiner.image(image(4), 1.12) == []
    assert joiner.component("confidence", image(3), 1.13) == []
    (frame,) = joiner.component("range", image(3), 1.14)
    assert kinds(frame) == ["intensity", "range", "confidence"]


def test_memory_is_bounded_whatever_comes() -> None:
    joiner, stamps_sent = ComponentJoiner(), range(1000, 1100)
    for stamp in stamps_sent:
        joiner.component("range", image(stamp), 1.0)
    done = [frame for stamp in stamps_sent for frame in joiner.image(image(stamp), 1.0)]
    assert len(done) >= len(stamps_sent) - MOST_WAITING
    assert sum("range" in kinds(frame) for frame in [*done, *joiner.due(9.0)]) == MOST_WAITING
    names = [kind.name.lower() for kind in ComponentKind if kind is not ComponentKind.METADATA]
    for name in (*names, *(f"{name}_{index}" for name in names for index in range(2, 9))):
        joiner.component(name, image(2000), 10.0)
    (frame,) = [*joiner.image(image(2000), 10.0), *joiner.due(19.0)]
    assert len(frame.parts) <= 1 + MOST_COMPONENTS


def test_a_component_that_ended_is_forgotten(joiner: ComponentJoiner) -> None:
    assert joiner.image(image(2), 1.0) == []
    assert stamps(joiner.forget("range")) == [2]
    assert stamps(joiner.image(image(3), 1.1)) == [3]


def test_a_range_image_of_its_own_is_not_doubled() -> None:
    joiner = ComponentJoiner()
    joiner.component("range", image(1, "Coord3D_C16"), 0.0)
    joiner.component("confidence", image(1), 0.0)
    (frame,) = joiner.image(image(1, "Coord3D_C16"), 0.0)
    assert kinds(frame) == ["range", "confidence"]


def test_names_of_ports_and_topics_are_told_from_others() -> None:
    assert kind_of("range") is ComponentKind.RANGE and kind_of("range_2") is ComponentKind.RANGE
    assert [kind_of(name) for name in ("rpc", "terminal", "raw", "range/points", "")] == [None] * 5
