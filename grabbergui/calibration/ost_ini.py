"""The INI form of a calibration, `ost.ini`, which ROS's camera_calibration writes beside `ost.yaml`.

Lines of `#` are comments. A section `[image]` has `width` and `height`; the next section bears the camera's
name and has `camera matrix`, `distortion`, `rectification` and `projection`. A name stands alone on its line,
its numbers on the lines below it. `mapping` returns them under the names of camera_info YAML.
"""

from __future__ import annotations

import math
import re
from typing import Any

from grabbergui.core.errors import UsageError

_SECTION = re.compile(r"\[([^\]]*)\]")
_ENTRIES = {
    "camera matrix": ("camera_matrix", 3),
    "distortion": ("distortion_coefficients", 1),
    "rectification": ("rectification_matrix", 3),
    "projection": ("projection_matrix", 3),
}
"The name of each matrix in YAML, and its rows."


def is_ini(text: str) -> bool:
    """Return whether a text is of this form and not YAML: it begins with a section in brackets."""
    first = next((line for line in _lines(text)), "")
    return bool(_SECTION.fullmatch(first)) and "\nwidth" in text.replace("\r", "")


def mapping(text: str, where: str) -> dict[str, Any]:
    """Return the entries as those of YAML. Raises UsageError naming `where`."""
    values: dict[str, Any] = {}
    numbers: list[float] = []
    found: dict[str, list[float]] = {}
    for line in _lines(text):
        if section := _SECTION.fullmatch(line):
            if section[1] != "image":
                if "camera_name" in values:
                    raise UsageError(
                        f"{where} has calibrations of {values['camera_name'][:40]} and {section[1][:40]}; "
                        "save each in a file of its own"
                    )
                values["camera_name"] = section[1]
        elif line in ("width", "height") or line in _ENTRIES:
            numbers = found.setdefault(line, [])
        else:
            numbers += [_number(field, where) for field in line.split()]
    for name in ("width", "height"):
        values[f"image_{name}"] = int(found[name][0]) if found.get(name) else 0
    for name, (key, rows) in _ENTRIES.items():
        data = found.get(name, [])
        if data:
            values[key] = {"rows": rows, "cols": len(data) // rows, "data": data}
    return values


def _lines(text: str) -> list[str]:
    lines = (line.strip() for line in text.splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def _number(field: str, where: str) -> float:
    try:
        number = float(field)
    except ValueError:
        raise UsageError(f"{where}: '{field[:20]}' is neither a number nor a name of ost.ini") from None
    if not math.isfinite(number):
        raise UsageError(f"{where}: {field[:20]} is not finite")
    return number
