"""Hand–eye calibration: its error with joint offsets and noisy corners.

python -m benchmarks hand_eye [--runs 10]
"""

from __future__ import annotations

import argparse
import itertools
import time

import numpy as np

from benchmarks._document import markdown
from benchmarks._results import Goal, Section, Table, machine
from benchmarks.servo import _hand_eye_scenes as scenes
from grabbergui.calibration import geometry
from grabbergui.servo.hand_eye.solver import solve

MM, DEGREES, VIEWS = 1.5, 0.15, 30
METHOD = f"""TEO's head and arm, with every joint off by 0.2° in either direction, and the camera some 7 mm
and 2.5° from its place in the drawing. {VIEWS} views of a board with 35 corners (15 × 10 cm), 1280×960 at
62°, in poses that are proposed for the nominal robot; corners have 0.5 px of noise. In the lower rows each
joint reading is noisy as well (0.2°, standard deviation). Errors are those of the camera's pose on its
mount, against the truth. The offset of the last joint counts as part of that pose, since no image can
separate the two."""


def measure(argv: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks hand_eye", description=__doc__)
    parser.add_argument("--runs", type=int, default=10, help="simulated robots of each kind")
    options = parser.parse_args(argv)
    rows, worst = [], np.zeros(2)
    for reading, kind in itertools.product((0.0, 0.2), scenes.KINDS):
        errors, sure, seconds = [], [], []
        for seed in range(options.runs):
            of = scenes.scene(kind, seed=seed)
            seen = scenes.views(of, VIEWS, seed=seed, reading=reading)
            began = time.thread_time()
            result = solve(of.arrangement, seen, scenes.CAMERA)
            seconds.append(time.thread_time() - began)
            true = scenes.observable(of)
            errors.append(
                (
                    1e3 * geometry.distance(result.camera, true),
                    np.degrees(geometry.angle_between(result.camera, true)),
                )
            )
            sure.append((1e3 * result.uncertainty[0], np.degrees(result.uncertainty[1])))
        median, most, stated = np.median(errors, axis=0), np.max(errors, axis=0), np.median(sure, axis=0)
        if not reading:
            worst = np.maximum(worst, most)
        rows.append(
            [
                f"{kind}, noisy readings" if reading else kind,
                *(f"{value:.2f} mm, {angle:.3f}°" for value, angle in (median, most, stated)),
                f"{np.median(seconds):.1f}",
            ]
        )
        print(*rows[-1], flush=True)
    return Section(
        "Hand–eye calibration",
        "python -m benchmarks hand_eye          # half a minute",
        METHOD,
        [Table(["arrangement", "error, median", "error, worst", "stated uncertainty", "seconds"], rows)],
        goals=[
            Goal(
                f"camera within {MM:g} mm and {DEGREES:g}° of the truth",
                f"{worst[0]:.2f} mm, {worst[1]:.3f}° at worst",
                bool(worst[0] < MM and worst[1] < DEGREES),
            )
        ],
        machine=machine(),
    )


def main(arguments: list[str] | None = None) -> None:
    print(markdown(measure(arguments)))


if __name__ == "__main__":
    main()
