"""A host that takes the sets of a rig, for a network namespace.

`python rig_host.py FILE SETS CLOCKS` opens the rig of a file, whose cameras have the clocks that
`wired_cameras.py` printed, and prints a JSON object: what became of the sets, and how far the times were off.
"""

from __future__ import annotations

import json
import sys

import numpy as np

import grabbergui

SAME_MOMENT_NS = 1_000_000
"The exposures of one pulse begin within this; those of two pulses are tens of milliseconds apart."


def main(file: str, count: int, clocks: dict[str, tuple[int, float]]) -> None:
    errors, unbounded, mismatched, sets = [], 0, 0, 0
    with grabbergui.open_rig(file) as rig:
        of = {name: clocks[rig[name].info.address] for name in rig}
        for images in rig.sets(count, timeout=60, depth=256):
            sets += 1
            true = []
            for name, frame in images.items():
                epoch, drift = of[name]
                exposed = epoch + frame.timestamp_ns - round(frame.timestamp_ns * drift / (1 + drift))
                stamp = images.stamps[name]
                errors.append((abs(stamp.time_ns - exposed), stamp.uncertainty_ns))
                unbounded += errors[-1][0] > errors[-1][1]
                true.append(exposed)
            mismatched += max(true) - min(true) > SAME_MOMENT_NS
        counts = rig.statistics
        drifts = {name: state.drift_ppm for name, state in rig.clocks.items()}
    figures = np.array(errors) / 1000
    print(
        json.dumps(
            {
                "sets": sets,
                "mismatched": mismatched,
                "frames": len(errors),
                "beyond_uncertainty": unbounded,
                "error_us": [float(each) for each in np.percentile(figures[:, 0], (50, 99, 100))],
                "uncertainty_us": [float(each) for each in np.percentile(figures[:, 1], (50, 99, 100))],
                "drift_ppm": {name: [drifts[name], -of[name][1] * 1e6] for name in of},
                "counts": counts.as_dict(),
            }
        ),
        flush=True,
    )


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), json.loads(sys.argv[3]))
