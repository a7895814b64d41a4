"""The faults that a simulated robot, its camera, or a stranger on its network can have, by name."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grabbergui.core.errors import UsageError

FAULTS = {
    "arm-blocked": "the arm does not move any more; its readings are true",
    "hand-drifts": "the hand's reading drifts away at 50 mm/s",
    "hand-far": "the hand's reading is 10^12 m away; without such a reading, a joint's is 10^12 rad",
    "hand-jumps": "the hand's reading is off by 0.3 m",
    "readings-freeze": "readings stay as they are, but for noise of 10 um and 10 urad",
    "readings-nan": "readings are not numbers",
    "readings-repeat": "readings stay as they are, to the last bit",
    "readings-stop": "no more readings",
    "camera-lost": "no more images",
    "image-repeats": "the camera sends its last image for ever, with new stamps",
    "images-alternate": "the camera sends its last two images for ever, with new stamps",
    "images-dark": "images are black",
    "images-late": "images arrive 1.0 s late, with the stamps of their exposure",
    "images-late-restamped": "images arrive 1.0 s late, with the stamps of their arrival",
    "images-mirrored": "images are mirrored",
    "images-noise": "images are noise",
    "false-readings": "a stranger sends old readings, with noise of 10 um, 200 times a second",
    "second-master": "a stranger sends the arm a velocity of -0.3 m/s along y, 200 times a second",
}
"What each fault does, by name."
DEFAULT_AFTER = 0.5
"Seconds of motion after which a fault begins by default."


@dataclass(frozen=True)
class Fault:
    """A fault and when it begins."""

    name: str
    after: float = DEFAULT_AFTER
    "Seconds after the arm's first motion."

    @staticmethod
    def parse(text: str) -> Fault:
        """Read `NAME[@SECONDS]`. Raises UsageError for an unknown name, and for a time that is none."""
        name, at, seconds = text.partition("@")
        if name not in FAULTS:
            raise UsageError(f"--fault {text}: there is no fault {name!r}; there are {', '.join(FAULTS)}")
        try:
            after = float(seconds) if at else DEFAULT_AFTER
        except ValueError:
            after = math.nan
        if not 0 <= after <= 3600:
            raise UsageError(f"--fault {text}: write {name}@SECONDS, 0 to 3600 after the arm first moves")
        return Fault(name, after)
