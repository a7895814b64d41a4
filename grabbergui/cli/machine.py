"""Commands about this machine (`list`, `doctor`) and the program on it (`setup`, `paths`)."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from grabbergui import doctor, sources
from grabbergui.cli.arguments import wait_time
from grabbergui.cli.process import dies_of_signals, passing_note
from grabbergui.core import environment
from grabbergui.core.environment import EXAMPLES, MANUAL, RESOURCES
from grabbergui.core.errors import MissingFileError, UsageError
from grabbergui.core.shared_folder import MEMORY
from grabbergui.core.visible_text import print_json, print_line, visible
from grabbergui.doctor.findings import Level
from grabbergui.net.ros2 import shared_memory
from grabbergui.setup import completion_scripts as completion
from grabbergui.setup.desktop_entry import DesktopEntry
from grabbergui.setup.ros2 import install_ros2
from grabbergui.setup.seen import Seen, somebody_types
from grabbergui.setup.udev_rule import UDEV_RULE, install_udev_rule, remove_udev_rule

_COLUMNS = ("uri", "vendor", "model", "serial", "address", "note")

_SEARCH_TIME, _ROS2_TIME = 2.0, 3.5
"""DDS participants announce themselves every three seconds, so that a search this long misses none."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_list(commands)
    _add_doctor(commands)
    _add_setup(commands)


def _add_list(commands: Any) -> None:
    parser = commands.add_parser(
        "list", help="list every source found", example="grabbergui list --timeout 5 --json"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON array")
    parser.add_argument(
        "--timeout",
        type=wait_time,
        metavar="S",
        help=f"seconds to search ({_SEARCH_TIME:g}; up to {_ROS2_TIME:g} for ROS 2)",
    )
    parser.set_defaults(run=_list)


def _list(options: argparse.Namespace) -> int:
    timeout = options.timeout
    longer: dict[str, float] = {}
    if timeout is None:
        timeout, longer = _SEARCH_TIME, {sources.SourceKind.ROS2: _ROS2_TIME}
    with dies_of_signals(), passing_note("searching …"):
        found = sources.discover(timeout, longer)
    if somebody_types():
        Seen().keep_sources(info.uri for info in found)
    if options.json:
        print_json([info.as_dict() for info in found], indent=2)
        return 0
    rows = [tuple(column.upper() for column in _COLUMNS)]
    rows += [tuple(visible(getattr(info, column)) for column in _COLUMNS) for info in found]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print_line("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    if not any(info.bus.startswith("GigE") for info in found):
        from grabbergui.driver.gige import reasons
        from grabbergui.driver.gige.interfaces import interfaces

        cards = [each for each in interfaces() if not each.loopback]
        if cards:
            print_line(f"no GigE Vision camera answers; {reasons.not_found(cards)}", error=True)
    return 0


def _add_doctor(commands: Any) -> None:
    parser = commands.add_parser(
        "doctor",
        help="check this machine for common problems; exit code 1 if there are any",
        example="grabbergui doctor",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON array")
    # The name of `setup udev` in older versions.
    parser.add_argument("--fix-udev", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument(
        "--clear-shared-memory",
        action="store_true",
        help="remove the shared memory of killed ROS 2 programs from /dev/shm",
    )
    parser.set_defaults(run=_doctor)


def _doctor(options: argparse.Namespace) -> int:
    if options.fix_udev:
        print_line(f"wrote {install_udev_rule()}; plug the camera in again")
        return 0
    if options.clear_shared_memory:
        removed = shared_memory.clear(shared_memory.leftovers(MEMORY))
        print_line(
            f"freed {shared_memory.megabytes(removed)}: {len(removed)} segments and ports without an owner"
        )
        return 0
    findings = []
    with dies_of_signals():
        for finding in doctor.check():
            findings.append(finding)
            if not options.json:
                print_line(f"{finding.level.value:8}{finding.text}", flush=True)
                if finding.remedy:
                    print_line(f"{'':8}→ {finding.remedy}", flush=True)
    if options.json:
        rows = [{"level": each.level.value, "text": each.text, "remedy": each.remedy} for each in findings]
        print_json(rows, indent=2)
    return 1 if any(finding.level is Level.PROBLEM for finding in findings) else 0


_PARTS = {
    "ros2": "ROS 2 and our interface package, into this program's environment",
    "udev": "the rule that lets users open USB3 Vision cameras (as root)",
    "desktop": "menu entry, icon, file types and man page, for this user",
    "completion": "completion of commands, sources and features in your shell",
}


def _add_setup(commands: Any) -> None:
    parser = commands.add_parser(
        "setup",
        help="install ROS 2, the udev rule, the desktop entry or shell completion",
        example="grabbergui setup desktop",
    )
    parser.add_argument(
        "part",
        metavar="|".join(_PARTS),
        choices=_PARTS,
        help="; ".join(f"{part}: {meaning}" for part, meaning in _PARTS.items()),
    )
    parser.add_argument("--remove", action="store_true", help="remove it (not ros2)")
    parser.add_argument(
        "--shell",
        choices=completion.SHELLS,
        help="the shell that gets the completion (your login shell)",
    )
    parser.add_argument(
        "--also",
        action="append",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="ros2: also build this interface package, unless one with its name is installed; repeatable",
    )
    parser.add_argument("--json", action="store_true", help="print the files as a JSON array")
    parser.set_defaults(run=_setup)

    parser = commands.add_parser(
        "paths",
        help="show the paths of the files that come with the program",
        example="grabbergui paths systemd",
    )
    parser.add_argument("name", nargs="?", choices=list(_paths()), help="print only this one's path")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_show_paths)


def _setup(options: argparse.Namespace) -> int:
    if options.shell is not None and options.part != "completion":
        raise UsageError(f"--shell has no effect on `setup {options.part}`, only on `setup completion`")
    if options.also and options.part != "ros2":
        raise UsageError(f"--also has no effect on `setup {options.part}`, only on `setup ros2`")
    done: Callable[[argparse.Namespace], tuple[list[Path], str]] = {
        "ros2": _ros2,
        "udev": _udev,
        "desktop": _desktop,
        "completion": _completion,
    }[options.part]
    files, advice = done(options)
    if options.json:
        print_json([str(file) for file in files], indent=2)
        return 0
    for file in files:
        print_line(f"{'removed' if options.remove else 'wrote'} {file}")
    if options.remove and not files:
        print_line("nothing to remove")
    if advice:
        print_line(advice)
    return 0


def _ros2(options: argparse.Namespace) -> tuple[list[Path], str]:
    if options.remove:
        raise UsageError("ROS 2 is removed with the environment that it is in: pip uninstall ros-rclpy …")
    for folder in options.also:
        if not (folder / "package.xml").is_file():
            raise MissingFileError(f"{folder} has no package.xml, so it is not a ROS 2 package")
    install_ros2(lambda step: print_line(step, error=True, flush=True), also=options.also)
    return [], "ROS 2 is ready: rclpy and grabber_interfaces"


def _udev(options: argparse.Namespace) -> tuple[list[Path], str]:
    if options.remove:
        removed = remove_udev_rule()
        return ([removed] if removed else []), ""
    return [install_udev_rule()], "plug the camera in again"


def _desktop(options: argparse.Namespace) -> tuple[list[Path], str]:
    entry = DesktopEntry(environment.data_home())
    files = entry.remove() if options.remove else entry.install(environment.program())
    entry.refresh()
    return files, ""


def _completion(options: argparse.Namespace) -> tuple[list[Path], str]:
    shell = options.shell or completion.login_shell()
    if options.remove:
        removed = completion.remove(shell)
        return ([removed] if removed else []), ""
    file = completion.install(shell, environment.program())
    return [file], completion.advice(shell, file)


def _paths() -> dict[str, Path]:
    """Return the paths that users look for, by the names that the manual gives them."""
    paths = {
        "resources": RESOURCES,
        "manual": MANUAL,
        "examples": EXAMPLES,
        "udev": UDEV_RULE,
        "systemd": RESOURCES / "systemd" / "grabbergui.service",
        "ros2": RESOURCES / "ros2",
        "fastdds": RESOURCES / "ros2" / "fastdds.xml",
        "yarp": RESOURCES / "yarp",
        "servo": RESOURCES / "servo",
        "scripts": RESOURCES / "scripts",
        "cache": environment.cache_home() / "grabbergui",
        "program": Path(environment.program()[0]),
    }
    return {name: path for name, path in paths.items() if name != "servo" or path.exists()}


def _show_paths(options: argparse.Namespace) -> int:
    paths = _paths()
    if options.name is not None:
        paths = {options.name: paths[options.name]}
    if options.json:
        print_json({name: str(path) for name, path in paths.items()}, indent=2)
    elif options.name is not None:
        print_line(paths[options.name])
    else:
        width = max(map(len, paths))
        for name, path in paths.items():
            print_line(f"{name:{width}}  {path}")
    return 0
