"""The JSON that each command prints with `--json`. The reference documents it, a test checks it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

_SETTING_FILE = "path of the file"


@dataclass(frozen=True)
class JsonOutput:
    """The output of one command: its form, and the fields of its objects."""

    form: str
    fields: Mapping[str, str] = field(default_factory=dict)
    "Their meanings by name; empty if the names are those of features, files or paths."


JSON_OUTPUT: dict[str, JsonOutput] = {
    "list": JsonOutput(
        "an array with an object for each source",
        {
            "uri": "the URI that opens it",
            "vendor": "its maker",
            "model": "its model",
            "serial": "its serial number",
            "bus": "`GigE Vision`, `USB3 Vision`, `YARP`, `ROS 2` and others",
            "address": "IP address, USB path, port or topic",
            "user_name": "its user-defined name (DeviceUserID)",
            "version": "its version",
            "hardware_id": "MAC address or GUID",
            "interface": "the network interface or bus on which it was found",
            "note": "why it cannot be opened, or which program controls it; empty if it can be",
        },
    ),
    "doctor": JsonOutput(
        "an array with an object for each finding",
        {
            "level": "`ok`, `note` or `problem`",
            "text": "what was found",
            "remedy": "what to do; may be empty",
        },
    ),
    "setup": JsonOutput("an array with the path of each file that was written or removed"),
    "paths": JsonOutput("an object with a path for each name"),
    "features": JsonOutput(
        "an array with an object for each feature",
        {
            "name": "the camera's own name",
            "kind": "`integer`, `float`, `boolean`, `enumeration`, `string` or `command`",
            "category": "the first category that contains it",
            "display_name": "the name for display",
            "value": "the value; null if it cannot be read",
            "minimum": "the least allowed number, or null",
            "maximum": "the largest allowed number, or null",
            "increment": "the step of numbers, or null",
            "unit": "the unit; may be empty",
            "representation": "`linear`, `logarithmic`, `pure`, `hex`, `ipv4`, `mac` or `boolean`",
            "access": "`NI`, `NA`, `WO`, `RO` or `RW`, as GenApi has them",
            "visibility": "`beginner`, `expert`, `guru` or `invisible`",
            "tooltip": "the camera's short description",
            "entries": "the entries of an enumeration that may be chosen now",
            "auto": "the name of its automatic mode, or null",
            "selectors": "the names of the features that select an instance",
            "problem": "why the description of it fails; empty if it does not",
        },
    ),
    "get": JsonOutput("an object with the value of each feature; addresses and hexadecimal numbers as text"),
    "set": JsonOutput(
        "an object with the value of each feature that the camera then reports, as `get` prints it"
    ),
    "save": JsonOutput(
        "an object",
        {"file": _SETTING_FILE, "saved": "number of settings", "left_out": "sentences about those left out"},
    ),
    "load": JsonOutput(
        "an object",
        {
            "settings": "an object for each setting of the file: `name`, `outcome`, the value `before`, the "
            "value `wanted`, and the `reason` if it was not written",
            "lost_lines": "sentences about lines that could not be read",
            "problem": "why the loading ended early; empty if it did not",
            "rolled_back": "the outcome of the roll-back of `--all-or-nothing`, or null",
        },
    ),
    "diff": JsonOutput(
        "an array with an object for each difference",
        {
            "name": "the setting",
            "first": "its value in the first set, or null",
            "second": "in the second, or null",
        },
    ),
    "files": JsonOutput(
        "for `list` an array with an object for each file; for the others an object with `file`, and `size` "
        "and `path` (get), `size` and `verified` (put) or `deleted` (delete)",
        {
            "name": "its name",
            "size": "bytes, or null",
            "modes": "the modes in which it can be opened",
            "details": "further features of the file, by name",
            "tooltip": "the camera's description of it",
        },
    ),
    "report": JsonOutput(
        "an object",
        {
            "file": "path of the report",
            "contents": "sentences about what it contains",
            "problems": "sentences about what could not be read",
        },
    ),
    "grab": JsonOutput(
        "an object",
        {
            "frames": "frames received",
            "incomplete": "frames that arrived incomplete, and were dropped",
            "lost": "frames that did not arrive, or came too fast for this command",
            "width": "of the first frame, in pixels",
            "height": "of the first frame, in pixels",
            "pixel_format": "of the first frame, its PFNC name",
            "fps": "frames per second, from the first to the last",
            "seconds": "from the first frame to the last",
            "bytes": "bytes of all frames as they arrived",
            "away": "seconds for which the source was lost",
        },
    ),
    "record": JsonOutput(
        "an object",
        {
            "frames": "frames written",
            "dropped": "frames that came too fast to be written",
            "seconds": "from the first frame to the last",
            "bytes": "size of the recording",
            "path": "the recording",
        },
    ),
    "events": JsonOutput(
        "an object for each event, on a line of its own",
        {
            "event": "its name",
            "id": "its number",
            "values": "the values in the message, by the names of features",
        },
    ),
    "rig": JsonOutput(
        "an object; which of the fields depends on the action",
        {
            "sets": "`check`: the sets by completeness, and their skew; `record`: sets written",
            "clocks": "`check`: the state of each camera's clock",
            "cameras": "`check`: the stream statistics of each camera",
            "links": "`budget`: what each link carries, and the share and settings of its cameras",
            "problems": "`check`, `budget`: sentences; empty if all is well",
            "measured": "`budget --measure`: bytes per second without loss, and whether more is lost",
            "verified": "`budget --verify`: each camera's frames, and those that were lost",
            "dropped": "`record`: sets that came too fast to be written",
            "seconds": "`record`: from the first set to the last",
            "bytes": "`record`: size of the recording",
            "path": "`record`: the recording",
            "counts": "`record`: the same as `sets` of `check`",
        },
    ),
    "trigger-group": JsonOutput(
        "an object",
        {
            "cameras": "number of cameras",
            "actions": "number of actions",
            "clock": "`PTP`, or `host` with `--no-ptp`",
            "spread_us": "for each action, microseconds between the earliest and the latest frame",
            "largest_spread_us": "the largest of them",
        },
    ),
}
"""By command."""
