"""Tuning a camera: delay from the operator's action to the register, and to the first image that shows it.

python -m benchmarks tuning [--repeats 60] [SOURCE …]
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import statistics
from collections.abc import Sequence

from benchmarks import _tuning_waits as waits
from benchmarks._results import Goal, Section, Table, machine
from benchmarks._tuning_cameras import HEIGHT, PIXEL_FORMAT, SOURCES, WIDTH
from benchmarks._tuning_window import DRAG_RATE, DRAG_SECONDS, HANDS, Seen, watch

ROUNDS, WRITES = 3, 30
"Rounds of the other waits, of which medians count; writes of the gain in each round."
METHOD = f"""The whole window, offscreen, on a camera of 3,500 nodes, with ten more categories of its panel
open. The camera streams {WIDTH}×{HEIGHT} {PIXEL_FORMAT} at 37.5 frames/s (118 MB/s; over GigE Vision, as
fast as a link of 125 MB/s allows), with the heartbeat on. The gain is changed {{repeats}} times by each
means at random moments: slider, arrow key, wheel, and Enter after a number was typed, each from within Qt's
event loop. *Register* is the time from just before the event to the write in the camera. *Image* is the time
to the first painted image of another grey value, which shows the gain of its exposure. The simulated cameras
apply a setting to the next frame; a slower camera's delay comes on top. With GigE Vision, YARP and ROS 2 the
camera runs in another process; with `sim:`, U3V (the protocol without a kernel's USB stack) and GenTL it runs
in the window's own. GenTL is EMVA's simulated producer: there the frame rate is changed instead of the gain,
and no two images can be distinguished.

Then the slider is dragged from end to end for {DRAG_SECONDS:g} s at {DRAG_RATE:g} signals a second. CPU is
that of the window's whole process: the stream, the painting and, where it runs there, the camera."""


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks tuning", description=__doc__)
    parser.add_argument("--repeats", type=int, default=60, help="adjustments by each means")
    parser.add_argument("source", nargs="*", choices=[[], *SOURCES], help=f"of {', '.join(SOURCES)}")
    options = parser.parse_args(arguments)
    before = machine()
    seen: dict[str, Seen] = {}
    for source in options.source or SOURCES:
        seen[source] = _in_a_process(source, options.repeats)
        print(source, *_register_row(seen[source]), flush=True)
    ours, own_writes = waits.ours(ROUNDS, WRITES)
    peer, writes = waits.aravis(ROUNDS, WRITES)
    ours |= waits.by_the_window(ROUNDS)
    reading = [
        "*driver*: `write_feature` until the acknowledge, on a thread of the window's process; *Aravis*: its "
        "`set_float_feature_value` on the same streaming camera, in a process of its own.",
        "*bare*: an empty request to the server and back, plus the served camera's own write while it "
        "streams to the window.",
        "All of them wait 0.12 to 0.24 s between writes, as the slider does; by then other code has replaced "
        "theirs in the processor's caches.",
        "Aravis changes format and region by stop, write, start, and waits for the first complete frame.",
        "GenTL's row of the dragging table has the frame rate dragged from 1 to 200 Hz, which explains its "
        "CPU.",
    ]
    if os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR):
        reading.append("Measured with real-time priority, since the machine was busy.")
    return Section(
        "Tuning",
        "python -m benchmarks tuning          # nine minutes",
        METHOD.format(repeats=options.repeats),
        [
            Table(
                ["source", *HANDS, "driver", "bare"],
                _rows(seen, _register_row),
                "Register, ms (median / 99 %):",
            ),
            Table(["source", "frame period", *HANDS], _rows(seen, _image_row), "Image, ms (median / 99 %):"),
            Table(
                ["source", "signals", "writes", "last write after", "image", "CPU"],
                _rows(seen, _drag_row),
                "Dragging the slider, ms:",
            ),
            Table(
                ["GigE Vision", "ours, ms", "Aravis, ms"],
                _wait_rows(ours, peer, own_writes, writes),
                "Other waits:",
            ),
        ],
        goals=[goal for source in seen for goal in _goals(source, seen[source], own_writes, writes)],
        reading=reading,
        machine=before,
        lacking="" if peer else "Aravis",
    )


def _in_a_process(source: str, repeats: int) -> Seen:
    """Each source gets a new window in a new process."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=watch, args=(theirs, source, repeats))
    process.start()
    theirs.close()
    try:
        seen: Seen = ours.recv()
    except EOFError:
        raise SystemExit(f"the window on {source} ended before it was measured") from None
    finally:
        process.join(30)
    return seen


def _rows(seen: dict[str, Seen], row: object) -> list[list[str]]:
    assert callable(row)
    return [[source, *row(of)] for source, of in seen.items()]


def _register_row(seen: Seen) -> list[str]:
    bare = f"{1e3 * (seen.round_trip + seen.own_write):.2f}" if seen.own_write else ""
    hands = [_both([one.register for one in seen.adjusted[hand]]) for hand in HANDS]
    return [*hands, _both(seen.driver_write), bare]


def _image_row(seen: Seen) -> list[str]:
    images = (_images(seen, hand) for hand in HANDS)
    return [f"{1e3 * seen.frame_period:.1f}", *(_both(values) if values else "–" for values in images)]


def _drag_row(seen: Seen) -> list[str]:
    dragged = seen.dragged
    assert dragged is not None
    image = _both(dragged.images) if dragged.images else "–"
    last = f"{1e3 * dragged.last:.1f}"
    return [str(dragged.signals), str(dragged.writes), last, image, f"{dragged.cores:.0%}"]


def _wait_rows(
    ours: dict[str, float], peer: dict[str, float], own_writes: Sequence[float], writes: Sequence[float]
) -> list[list[str]]:
    labels = {
        "open first": "open a camera with an unknown description",
        "open": "open",
        "start": "start, to the first frame",
        "pixel format": "change the pixel format while streaming, to the first such frame",
        "region": "change the region while streaming, to the first such frame",
        "stop": "stop",
        "start and stop": "start and stop",
        "take control": "take control from another program",
        "switch": "switch to another open camera, to its first painted image",
        "program start": "start the program with a known camera, to the first painted image",
    }
    rows = [
        [label, f"{1e3 * ours[name]:.0f}", f"{1e3 * peer[name]:.0f}" if name in peer else "–"]
        for name, label in labels.items()
    ]
    return [*rows, ["write the gain (median / 99 %)", _both(own_writes), _both(writes) if writes else "–"]]


def _images(seen: Seen, hand: str) -> list[float]:
    return [one.image for one in seen.adjusted[hand] if one.image is not None]


def _both(values: Sequence[float]) -> str:
    return f"{1e3 * statistics.median(values):.2f} / {1e3 * _late(values):.2f}"


def _late(values: Sequence[float]) -> float:
    """Return the value that 99 of 100 do not exceed."""
    return sorted(values)[max(-(-99 * len(values) // 100) - 1, 0)]


def _goals(source: str, seen: Seen, driver: Sequence[float], aravis: Sequence[float]) -> list[Goal]:
    registers = [one.register for hand in HANDS for one in seen.adjusted[hand]]
    images = [image for hand in HANDS for image in _images(seen, hand)]
    goals = []
    if source == "GigE":
        goals.append(_goal(f"{source}: register, median under 3 ms", statistics.median(registers), 3e-3))
        goals.append(_goal(f"{source}: register, 99 % under 15 ms", _late(registers), 15e-3))
        if aravis:
            limit = 1.5 * statistics.median(aravis)
            goals.append(
                _goal(
                    f"{source}: the driver's write within 1.5 × Aravis's ({1e3 * limit:.2f} ms)",
                    statistics.median(driver),
                    limit,
                )
            )
            goals.append(
                _goal(
                    f"{source}: slider to register within 1.5 × Aravis's own write ({1e3 * limit:.2f} ms)",
                    statistics.median(one.register for one in seen.adjusted["slider"]),
                    limit,
                )
            )
    if seen.own_write:
        limit = 1.5 * (seen.round_trip + seen.own_write)
        goals.append(
            _goal(
                f"{source}: register within 1.5 × bare request + write ({1e3 * limit:.2f} ms)",
                statistics.median(registers),
                limit,
            )
        )
    period = seen.frame_period
    if images:
        goals.append(
            _goal(f"{source}: image, median under two frame periods", statistics.median(images), 2 * period)
        )
        goals.append(_goal(f"{source}: image, 99 % under three frame periods", _late(images), 3 * period))
    return goals + _drag_goals(source, seen)


def _drag_goals(source: str, seen: Seen) -> list[Goal]:
    dragged, period = seen.dragged, seen.frame_period
    assert dragged is not None
    landed = Goal(
        f"{source}: dragged, last value written within three frame periods",
        f"{1e3 * dragged.last:.1f} ms",
        0 <= dragged.last < 3 * period,
    )
    if not dragged.images:
        return [landed]  # what is dragged is the frame rate itself, up to 200 Hz
    middle, late = statistics.median(dragged.images), _late(dragged.images)
    measured = f"{1e3 * middle:.1f} and {1e3 * late:.1f} ms"
    met = middle < 2 * period and late < 3 * period
    return [
        landed,
        Goal(f"{source}: dragged, image: median within two frame periods, 99 % within three", measured, met),
        Goal(f"{source}: dragged, under half a core", f"{dragged.cores:.0%}", dragged.cores < 0.5),
    ]


def _goal(asked: str, seconds: float, limit: float) -> Goal:
    return Goal(asked, f"{1e3 * seconds:.2f} ms", seconds < limit)


if __name__ == "__main__":
    from benchmarks._document import markdown

    print(markdown(measure()))
