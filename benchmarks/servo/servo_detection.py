"""Duration of the detection in a frame, and the error of its corners, with and without the pyramid.

python -m benchmarks servo_detection [--repeats 25] [--faces FOLDER]
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks._document import markdown
from benchmarks._results import Chart, Goal, Section, Table, machine
from benchmarks.servo import _heads
from grabbergui.calibration.markers import ArucoDetector
from grabbergui.core.calibration import Calibration
from grabbergui.core.scheduling import single_threaded
from grabbergui.driver.sim import person
from grabbergui.servo.detection import FaceDetector
from grabbergui.servo.face_detectors import CascadeFaceDetector, YuNetFaceDetector, installed_model

SIZES = (("640×480", 640, 480), ("1080p", 1920, 1080), ("8.8 MP", 4096, 2160))
DICTIONARY, FIRST_ID, MARKERS = "4X4_50", 15, 6
BAR_MS, FACE_BAR_MS = 30.0, 10.0
CASCADE, YUNET = "faces, cascade", "faces, YuNet"
HEADS_AT = {1.2: 430, 2.0: 258}
"Distance of rendered heads, metres, to the side of the square around one, pixels, at a field of view of 60°."
HEADS_HEADER = ("heads at", "face", "cascade", "others", "YuNet", "others")
HEADS_METHOD = """faces laid on an ellipsoid, in 30 poses (yaw up to ±40°, pitch up to ±25°) and three
lights, in 1080p with noise: a drawn face and, with `--faces FOLDER`, photographs, such as those in the tests
of the package face-recognition. *Others* are boxes without a head."""
HEADER = ("image", "detector", "median, ms", "95 %, ms", "found", "corner error, px", "smallest, px")
METHOD = """One image of each size, OpenCV on one thread: six markers, each a twelfth of the image wide and
turned by a few degrees, and a face, on a background of clouds, lines and noise. *Reduced search* is what
servoing uses: the image is halved until it has no more than 0.7 MP, markers are searched in that, and their
corners are located again in the full image; *full image* searches all of it. Times include the poses,
and are CPU times of that thread. Errors are those of the corners against where they were drawn."""


def measure(argv: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks servo_detection", description=__doc__)
    parser.add_argument("--repeats", type=int, default=25, help="of each, in one image")
    parser.add_argument("--faces", type=Path, metavar="FOLDER", help="photographs whose faces are turned too")
    options = parser.parse_args(argv)
    before = machine()
    single_threaded()
    rows, times = [], {}
    for label, width, height in SIZES:
        calibration = Calibration.from_field_of_view(width, height, 60)
        grey, corners = busy_image(width, height)
        finders: tuple[tuple[str, ArucoDetector | FaceDetector], ...] = (
            ("ArUco, reduced search", ArucoDetector(DICTIONARY, 0.1, calibration)),
            ("ArUco, full image", ArucoDetector(DICTIONARY, 0.1, calibration, search_pixels=1 << 30)),
            *face_detectors(calibration),
        )
        for name, finder in finders:
            found = finder.detect(grey)
            median, worst = milliseconds(partial(finder.detect, grey), options.repeats)
            times[name, label] = median
            of_markers = isinstance(finder, ArucoDetector)
            error = f"{corner_error(found, corners):.2f}" if of_markers else ""
            smallest = (
                str(smallest_marker(finder, width, height)) if isinstance(finder, ArucoDetector) else ""
            )
            whole = f"{len(found)} of {MARKERS if of_markers else 1}"
            rows.append([label, name, f"{median:.1f}", f"{worst:.1f}", whole, error, smallest])
            print(*rows[-1], flush=True)
    names = tuple(dict.fromkeys(name for name, _ in times))
    large = times["ArUco, reduced search", "8.8 MP"]
    goals = [Goal(f"markers in 8.8 MP within {BAR_MS:g} ms (median)", f"{large:.1f} ms", large < BAR_MS)]
    face_ms = times.get((YUNET, "1080p"))
    if face_ms is not None:
        goal = f"faces in 1080p by YuNet within {FACE_BAR_MS:g} ms (median)"
        goals.append(Goal(goal, f"{face_ms:.1f} ms", face_ms < FACE_BAR_MS))
    found_heads = recall_of_faces(options.faces)
    return Section(
        "Detection for servoing",
        "python -m benchmarks servo_detection          # half a minute",
        METHOD,
        [Table([*HEADER], rows), Table([*HEADS_HEADER], found_heads)],
        [
            Chart(
                "servo-detection",
                "Detection in one frame, median",
                "ms",
                [label for label, *_ in SIZES],
                {name: [times[name, label] for label, *_ in SIZES] for name in names},
                BAR_MS,
                f"{BAR_MS:g} ms",
            )
        ],
        goals,
        [
            "*smallest*: how many pixels wide a marker must be, alone and seen from the front, to be found "
            "anywhere in the image; the width of a marker of 10 cm is 10 cm × focal length in pixels / "
            "distance.",
            f"Heads: {HEADS_METHOD}",
            "While a marker is seen, heads are not searched, so a frame costs one or the other and, while "
            "waiting for the marker, both.",
        ],
        before,
    )


def face_detectors(calibration: Calibration) -> list[tuple[str, FaceDetector]]:
    """Return the face detectors that can be used here, by name."""
    found: list[tuple[str, FaceDetector]] = [(CASCADE, CascadeFaceDetector(calibration))]
    model = installed_model()
    return [*found, (YUNET, YuNetFaceDetector(model, calibration))] if model is not None else found


def recall_of_faces(photographs: Path | None) -> list[list[str]]:
    """Return rows: a face, its distance, and for each detector the numbers of heads and of others."""
    faces = [_heads.drawn_face(), *(_heads.photographed_faces(photographs) if photographs else ())]
    random, rows = np.random.default_rng(0), []
    for (metres, side), face in itertools.product(HEADS_AT.items(), faces):
        counts: dict[str, list[int]] = {CASCADE: [0, 0], YUNET: [0, 0]}
        for light, (yaw, pitch) in itertools.product(_heads.LIGHTS, _heads.POSES):
            image, middle = _heads.scene(face, yaw, pitch, light, side, random)
            for name, detector in face_detectors(Calibration.from_field_of_view(1920, 1080, 60)):
                boxes = [each.box for each in detector.detect(image)]
                hits = sum(
                    abs(x + width / 2 - middle[0]) < 0.35 * side
                    and abs(y + height / 2 - middle[1]) < 0.35 * side
                    for x, y, width, height in boxes
                )
                counts[name][0] += hits > 0
                counts[name][1] += len(boxes) - hits
        total = len(_heads.LIGHTS) * len(_heads.POSES)
        row = [f"{metres:g} m", face.name]
        for hits, others in counts.values():
            row += [f"{hits} of {total} ({100 * hits / total:.0f} %)", str(others)]
        rows.append(row)
        print(*row, flush=True)
    return rows


def milliseconds(work: Callable[[], Any], repeats: int) -> tuple[float, float]:
    """Return the median and 95th percentile of the CPU time, milliseconds."""
    times = []
    for _ in range(repeats):
        began = time.thread_time()
        work()
        times.append(1e3 * (time.thread_time() - began))
    return statistics.median(times), float(np.percentile(times, 95))


def corner_error(found: list[Any], corners: dict[int, NDArray[np.float64]]) -> float:
    """Return the root mean square error of the detected markers' corners, pixels."""
    apart = [marker.corners - corners[marker.marker_id] for marker in found if marker.marker_id in corners]
    return float(np.sqrt((np.array(apart) ** 2).sum(axis=-1).mean()))


def smallest_marker(finder: ArucoDetector, width: int, height: int) -> int:
    """Return the side in pixels of the smallest marker that is found at all of some places."""
    random, side = np.random.default_rng(2), 8
    while side < 200:
        image = np.full((height, width), 120, np.float32)
        middles = random.uniform(0.3, 0.7, (3, 2)) * (width, height)
        grey = []
        for middle in middles:
            alone = image.copy()
            lay_marker(alone, FIRST_ID, side, (float(middle[0]), float(middle[1])), random.uniform(-20, 20))
            grey.append(np.clip(cv2.GaussianBlur(alone, (0, 0), 0.8), 0, 255).astype(np.uint8))
        if all(len(finder.detect(each)) == 1 for each in grey):
            return side
        side += max(2, side // 10)
    return side


def busy_image(width: int, height: int) -> tuple[NDArray[np.uint8], dict[int, NDArray[np.float64]]]:
    """Return an image, and the (4, 2) corners of its markers by id."""
    random = np.random.default_rng(1)
    image = cv2.resize(random.integers(60, 190, (24, 32), np.uint8), (width, height)).astype(np.float32)
    for _ in range(60):
        ends = random.integers(0, (width, height), (2, 2))
        cv2.line(image, tuple(map(int, ends[0])), tuple(map(int, ends[1])), int(random.integers(0, 255)), 3)
    side, corners = width // 12, {}
    for index in range(MARKERS):
        middle = side * 1.6 + index * (width - 3 * side) / MARKERS, height * (0.3 + 0.22 * (index % 3))
        corners[FIRST_ID + index] = lay_marker(image, FIRST_ID + index, side, middle, random.uniform(-8, 8))
    size = width // 7
    place = slice(height - size, height), slice(width // 40, width // 40 + size)
    face = cv2.resize(person.face(256), (size, size))
    image[place] += face[..., 3] * (255 * face[..., 1] - image[place])
    noisy = cv2.GaussianBlur(image, (0, 0), 0.8) + random.normal(0, 3, (height, width))
    return np.clip(noisy, 0, 255).astype(np.uint8), corners


def lay_marker(
    image: NDArray[np.float32], marker_id: int, side: int, middle: tuple[float, float], degrees: float
) -> NDArray[np.float64]:
    """Draw a marker of `side` pixels with its white border; return its corners, (4, 2)."""
    fine, border = 4, side // 5
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{DICTIONARY}"))
    drawn = cv2.aruco.generateImageMarker(dictionary, marker_id, fine * side)
    drawn = np.pad(drawn, fine * border, constant_values=235)
    drawn = cv2.GaussianBlur(drawn, (0, 0), 0.5 * fine)  # or its edges would be stairs
    whole = fine * (side + 2 * border)
    centre = ((whole - 1) / 2, (whole - 1) / 2)
    turn = np.asarray(cv2.getRotationMatrix2D(centre, degrees, 1 / fine), np.float64)
    turn[:, 2] += np.array(middle) - (whole - 1) / 2
    height, width = image.shape
    ink = cv2.warpAffine(drawn.astype(np.float32), turn, (width, height), flags=cv2.INTER_LINEAR)
    cover = cv2.warpAffine(np.ones_like(drawn, np.float32), turn, (width, height), flags=cv2.INTER_LINEAR)
    np.copyto(image, ink, where=cover > 0.5)
    low, high = fine * border - 0.5, fine * (border + side) - 0.5
    square = np.array([*itertools.product((low, high), repeat=2)])[[0, 2, 3, 1]]
    return np.asarray(square @ turn[:, :2].T + turn[:, 2], np.float64)


def main(arguments: list[str] | None = None) -> None:
    print(markdown(measure(arguments)))


if __name__ == "__main__":
    main()
