"""`grabbergui rig`: several cameras as one: make its file, check it, plan its link, record, serve."""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.arguments import count, counted, part, positive, wait_time
from grabbergui.cli.process import passing_note, progress_note, stop_on_signals, supervised
from grabbergui.core.environment import check_folder_of
from grabbergui.core.errors import ExistingFileError, FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.uri import SourceUri
from grabbergui.core.visible_text import print_json, print_line

if TYPE_CHECKING:
    from grabbergui.core.frame import Frame
    from grabbergui.recording.pre_trigger import PreTriggerBuffer
    from grabbergui.recording.recorder import RecordingProgress
    from grabbergui.rig.grabber import RigGrabber
    from grabbergui.rig.link_budget import LinkBudget
    from grabbergui.rig.link_measurement import RateSearch
    from grabbergui.rig.rig_file import RigEntry

MOST_INCOMPLETE = 0.1
"Part of the sets that may be incomplete, as the first ones often are, before `check` calls it a problem."
CHECK_SECONDS = 3.0
"Seconds for which `check` watches the stream without `-t`."


AFTER = 1.0
"Seconds for which a recording goes on after what released it."
OPTIONS_OF = {
    "new": {"trigger": "--trigger", "rate": "--rate", "leader": "--leader"},
    "budget": {"apply": "--apply", "undo": "--undo", "measure": "--measure", "verify": "--verify"},
    "record": {
        **{"out": "--out", "sets": "--sets", "size": "--size", "segment": "--segment"},
        **{"before": "--before", "after": "--after", "on": "--on"},
    },
    "serve": {"yarp": "--yarp", "nameserver": "--nameserver", "ros2": "--ros2"},
}
"""The options that only one action has."""


def add_commands(commands: Any) -> None:
    """Add the parser of this family."""
    parser = commands.add_parser(
        "rig",
        help="use several cameras as one: matched sets of frames, one clock, one trigger",
        example="grabbergui rig new stereo.yaml left=gige:GV01 right=gige:GV02 --trigger action --rate 10",
    )
    parser.add_argument(
        "action",
        choices=("new", "check", "budget", "record", "serve"),
        help="new: write the rig's file; check: clocks, sets and losses; budget: divide the link; record: "
        "into one .mcap; serve: on YARP and ROS 2, a port or namespace for each camera",
    )
    parser.add_argument("file", metavar="FILE", type=Path, help="the rig's file, such as stereo.yaml")
    parser.add_argument(
        "sources", metavar="NAME=SOURCE", nargs="*", help="with new: the cameras (all that are found)"
    )
    parser.add_argument(
        "-t",
        "--seconds",
        type=wait_time,
        metavar="S",
        help="check, record, budget --verify: for S seconds; with --before the wait for --on counts, too",
    )
    parser.add_argument("--json", action="store_true", help="check, budget, record: print one JSON object")

    new = parser.add_argument_group("new")
    new.add_argument(
        "--trigger", choices=("free", "software", "action", "line"), help="what makes the frames"
    )
    new.add_argument("--rate", type=positive, metavar="HZ", help="triggers per second")
    new.add_argument("--leader", metavar="NAME", help="with --trigger line: whose output triggers the others")

    budget = parser.add_argument_group("budget")
    budget.add_argument("--apply", action="store_true", help="write the delays into the rig's file")
    budget.add_argument(
        "--measure",
        action="store_true",
        help="find the rate that the link carries, by the cameras' streams at rising rates (some 30 s)",
    )
    budget.add_argument(
        "--verify", action="store_true", help="stream with the delays for -t seconds, and count what is lost"
    )
    budget.add_argument("--undo", action="store_true", help="take them out of it")

    record = parser.add_argument_group("record")
    record.add_argument("--out", type=Path, metavar="PATH", help="the recording, such as run.mcap")
    record.add_argument("-n", "--sets", type=count, metavar="SETS", help="end after this many sets")
    record.add_argument("--size", type=positive, metavar="MB", help="end after this many megabytes")
    record.add_argument("--segment", type=wait_time, metavar="S", help="begin a new file every S seconds")
    record.add_argument(
        "--before", type=wait_time, metavar="S", help="keep the last S seconds in memory until --on happens"
    )
    record.add_argument("--after", type=wait_time, metavar="S", help="go on for S seconds after that (1)")
    record.add_argument(
        "--on",
        action="append",
        type=_occasion,
        metavar="WHAT",
        help="with --before: `key` (Enter), a camera's event such as Line1RisingEdge, or a brightness as in"
        " `level:50%%`; repeatable",
    )

    serve = parser.add_argument_group("serve")
    serve.add_argument("--yarp", metavar="/PORT", help="ports /PORT/NAME, with requests at /PORT/NAME/rpc")
    serve.add_argument("--nameserver", metavar="HOST:PORT", default="", help="another YARP name server")
    serve.add_argument("--ros2", metavar="/NAME", help="nodes /NAME/CAMERA, with topics below them")
    parser.set_defaults(run=_rig)


def _rig(options: argparse.Namespace) -> int:
    if options.sources and options.action != "new":
        raise UsageError(f"rig {options.action} takes no cameras: they are in {options.file}")
    for action, names in OPTIONS_OF.items():
        for name, option in names.items():
            if action != options.action and getattr(options, name) not in (None, False, ""):
                raise UsageError(f"{option} goes with rig {action}, not with rig {options.action}")
    if options.seconds is not None and not (options.action in ("check", "record") or options.verify):
        raise UsageError(
            f"-t goes with rig check, rig record and rig budget --verify, not with rig {options.action}"
        )
    actions = {"new": _new, "check": _check, "budget": _budget, "record": _record, "serve": _serve}
    return actions[options.action](options)


def _new(options: argparse.Namespace) -> int:
    from grabbergui.rig import rig_file
    from grabbergui.rig.rig_file import TriggerEntry

    check_folder_of(options.file)
    if options.file.exists():
        raise ExistingFileError(f"{options.file} is there already; nothing is overwritten. Name another file")
    cameras = dict(map(_named_source, options.sources)) if options.sources else _found()
    if options.sources and len(cameras) < len(options.sources):
        raise UsageError("two cameras have one name")
    trigger = TriggerEntry(options.trigger or "free", options.rate or 0.0, leader=options.leader or "")
    entry = rig_file.of_sources(cameras, trigger=trigger)
    rig_file.write(options.file, entry)
    print_line(f"{options.file}: {', '.join(f'{name} ({uri})' for name, uri in cameras.items())}")
    print_line(f"open it as rig:{options.file}, or try it with `grabbergui rig check {options.file}`")
    return 0


def _named_source(text: str) -> tuple[str, str]:
    from grabbergui import sources

    name, equals, uri = text.partition("=")
    if not equals or ":" in name:
        raise UsageError(f"'{text}': write a name and a source, as in left=gige:GV01")
    sources.parse(uri)
    return name, uri


def _found() -> dict[str, str]:
    from grabbergui import sources

    infos = [info for info in sources.discover() if info.uri.startswith(("gige:", "u3v:"))]
    if not infos:
        raise UsageError(
            "no camera was found; name them, as in left=gige:192.168.0.10 right=gige:192.168.0.11"
        )
    return {f"camera{number}": info.uri for number, info in enumerate(infos, 1)}


def _opened(file: Path, stack: ExitStack, entry: RigEntry | None = None) -> RigGrabber:
    """Open the rig of a file, or another content for it, until the stack is closed."""
    from grabbergui.rig import source
    from grabbergui.rig.grabber import RigGrabber

    grabber = source.create(SourceUri("rig", str(file))) if entry is None else source.of_entry(entry)
    if not isinstance(grabber, RigGrabber):
        raise UsageError(f"{file} is a recording, and has no cameras; play it as rig:{file}")
    stack.callback(grabber.close)
    grabber.open()
    return grabber


def _check(options: argparse.Namespace) -> int:
    from grabbergui.rig.budget_settings import budgets_of

    with stop_on_signals() as stop, ExitStack() as stack:
        rig = _opened(options.file, stack)
        _stream(rig, options.seconds or CHECK_SECONDS, stop)
        counts, states = rig.counts(), rig.clock_states()
        statistics = {name: camera.statistics() for name, camera in rig.cameras.items()}
        budgets = budgets_of(rig.entry, rig.cameras)
        findings, triggers = rig.trigger_findings(), rig.trigger_counts()
    problems = [problem for budget in budgets for problem in budget.problems]
    problems += [f"{name}: {state.problem}" for name, state in states.items() if state.problem]
    problems += [f"{name}: {finding.sentence}" for name, finding in findings.items() if finding.sentence]
    for name, each in statistics.items():
        if each.lost or each.incomplete:
            problems.append(
                f"{name}: {counted(each.lost + each.incomplete, 'frame')} lost on the wire;"
                f" `grabbergui rig budget {options.file}` plans the link"
            )
    if not counts.complete:
        problems.append("no set was complete")
    elif counts.incomplete > MOST_INCOMPLETE * counts.sets:
        problems.append(f"{counts.incomplete} of {counts.sets} sets are incomplete")
    if options.json:
        print_json(
            {
                "sets": counts.as_dict(),
                "clocks": {name: vars(state) for name, state in states.items()},
                "cameras": {name: each.as_dict() for name, each in statistics.items()},
                "problems": problems,
            }
        )
        return 1 if problems else 0
    width = max(map(len, statistics))
    for name, each in statistics.items():
        lost = each.lost + each.incomplete
        missed = triggers[name].missed if name in triggers else 0
        print_line(
            f"{name:{width}}  in {counts.sets - counts.missing[name]} of {counts.sets} sets,"
            f" {counted(lost, 'frame')} lost, {each.packets_resent} packets resent"
            f"{f', {missed} triggers missed' if missed else ''}; clock: {states[name]}"
        )
    print_line(f"sets: {counts}")
    for problem in problems:
        print_line(f"problem: {problem}")
    return 1 if problems else 0


def _stream(rig: RigGrabber, seconds: float, stop: threading.Event) -> None:
    """Let the rig stream for some seconds, and show how its sets come out."""
    with closing(rig.open_queue(64)) as queue, progress_note() as show:
        rig.start()
        end = time.monotonic() + seconds
        while not stop.is_set() and (left := end - time.monotonic()) > 0:
            show(lambda left=left: f"{rig.counts().brief}; {left:.0f} s left, Ctrl-C ends it")  # type: ignore[misc]
            with suppress(FrameTimeoutError):
                queue.get(min(left, 0.1))


def _measure(rig: RigGrabber, stop: threading.Event) -> RateSearch:
    """Find the rate of the network that the rig's cameras share."""
    from grabbergui.rig.budget_settings import loads_of
    from grabbergui.rig.link_measurement import measure

    loads = [load for load in loads_of(rig.entry, rig.cameras) if load.packet_size]
    if not loads:
        raise UsageError("--measure: none of the cameras is on a network")
    with passing_note("measuring the link …") as show:
        return measure(
            rig.cameras, loads, rig.entry.link.rate, lambda trial: show(f"{trial}; measuring"), stop.is_set
        )


def _lost_with(entry: RigEntry, options: argparse.Namespace, stop: threading.Event) -> dict[str, list[int]]:
    """Stream with a budget's settings; return each camera's frames and those that were lost."""
    with ExitStack() as stack:
        rig = _opened(options.file, stack, entry)
        _stream(rig, options.seconds or CHECK_SECONDS, stop)
        statistics = {name: camera.statistics() for name, camera in rig.cameras.items()}
    return {
        name: [each.frames + each.incomplete + each.lost, each.incomplete + each.lost]
        for name, each in statistics.items()
    }


def _budget(options: argparse.Namespace) -> int:
    from grabbergui.rig import rig_file
    from grabbergui.rig.budget_settings import budgets_of, with_budget, without_budget

    if options.undo and (options.apply or options.measure or options.verify):
        raise UsageError("--undo takes the delays out of the file; write it alone")
    entry = rig_file.read(options.file)
    if options.undo:
        rig_file.write(options.file, without_budget(entry))
        print_line(f"{options.file}: the delays are taken out; the cameras keep their own")
        return 0
    measured: RateSearch | None = None
    with stop_on_signals() as stop, ExitStack() as stack:
        rig = _opened(options.file, stack)
        if options.measure:
            measured = _measure(rig, stop)
            if measured.limited and measured.carried:
                entry = replace(entry, link=replace(entry.link, rate=measured.carried))
        budgets = budgets_of(entry, rig.cameras)
        problems = [problem for budget in budgets for problem in budget.problems]
        if measured is not None and not measured.carried:
            problems.append("the link loses packets at any rate: check cables and the switch")
        planned = with_budget(entry, budgets)
        stack.close()
        lost = _lost_with(planned, options, stop) if options.verify and not problems else {}
    problems += [
        f"{name}: {counted(gone, 'frame')} of {sent} lost with the delays; write a smaller link.share"
        for name, (sent, gone) in lost.items()
        if gone
    ]
    if options.apply and not problems:
        rig_file.write(options.file, planned)
    if options.json:
        content = {"links": [_as_dict(budget) for budget in budgets], "problems": problems}
        if measured is not None:
            content["measured"] = {"rate": measured.carried, "limited": measured.limited}
        if lost:
            content["verified"] = {
                name: {"frames": sent, "lost": gone} for name, (sent, gone) in lost.items()
            }
        print_json(content)
        return 1 if problems else 0
    if measured is not None:
        more = (
            "of more, packets are lost" if measured.limited else "nothing was lost, so the file's rate counts"
        )
        print_line(f"measured: {measured.carried / 1e6:.2f} MB/s arrive without loss; {more}")
    if alone := [name for name in rig.cameras if not any(name in budget.names for budget in budgets)]:
        print_line(f"{', '.join(alone)}: not on a network or USB, so there is no link to divide")
    for budget in budgets:
        rows = budget.table()
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        for row in rows:
            print_line("  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())
    if lost:
        sent, gone = (sum(each) for each in zip(*lost.values(), strict=True))
        print_line(f"verified: {gone} of {counted(sent, 'frame')} lost with these delays")
    for problem in problems:
        print_line(f"problem: {problem}")
    if budgets and not problems:
        written = f"written into {options.file}" if options.apply else "write it into the file with --apply"
        print_line(f"all frames fit; {written}")
    return 1 if problems else 0


def _as_dict(budget: LinkBudget) -> dict[str, Any]:
    return {
        "rate": budget.link.rate,
        "usable": budget.link.usable,
        "need": budget.need,
        "cameras": {
            each.load.name: {
                "need": each.load.need,
                "share": each.share,
                "frame_time": each.frame_time,
                "settings": each.settings,
            }
            for each in budget.allotments
        },
    }


def _record(options: argparse.Namespace) -> int:
    from grabbergui.recording.recorder import RecordingLimits
    from grabbergui.rig.recording import begin

    if options.out is None:
        raise UsageError("rig record: name the recording, as in --out run.mcap")
    check_folder_of(options.out)
    if bool(options.on) != (options.before is not None):
        raise UsageError("rig record: --before S and --on WHAT go together")
    size = None if options.size is None else options.size * 1e6
    with stop_on_signals() as stop, ExitStack() as stack:
        rig = _opened(options.file, stack)
        buffer = _pre_trigger(rig, options, stack) if options.on else None
        # With --before, `-t` limits the wait as well: nothing of --on need ever happen.
        limits = RecordingLimits(options.sets, None if buffer is not None else options.seconds, size)
        recorder = begin(rig, options.out, limits, source=buffer, segment=options.segment)
        recorder.start()
        try:
            rig.start()
            end = time.monotonic() + (options.seconds or math.inf) if buffer is not None else math.inf
            with progress_note() as show:
                while not recorder.wait(0.1) and not stop.is_set() and time.monotonic() < end:
                    show(lambda: _so_far(recorder.progress, buffer))
        finally:
            recorder.stop()
            recorder.wait()
        rig.stop()
        counts, progress = rig.counts(), recorder.progress
    if options.json:
        print_json(
            {
                "sets": progress.frames,
                "dropped": progress.dropped,
                "seconds": progress.seconds,
                "bytes": progress.size,
                "path": str(options.out),
                "counts": counts.as_dict(),
            }
        )
    elif not progress.frames:
        print_line("nothing was written: " + ("nothing of --on happened" if options.on else "no set arrived"))
        print_line(f"sets: {counts}")
    else:
        play = f"play it as rig:{options.out}" if options.segment is None else "each file plays as rig:FILE"
        print_line(
            f"{options.out}: {counted(progress.frames, 'set')} in {progress.seconds:.2f} s,"
            f" {progress.size / 1e6:.1f} MB; {progress.dropped} dropped; {play}"
        )
        print_line(f"all sets of the stream: {counts}")
    if progress.reason:
        raise GrabberError(progress.reason)
    return 0


def _so_far(progress: RecordingProgress, buffer: PreTriggerBuffer | None) -> str:
    waiting = f"{counted(buffer.kept, 'set')} kept; " if buffer is not None else ""
    dropped = f", {progress.dropped} dropped" if progress.dropped else ""
    written = f"{counted(progress.frames, 'set')} in {progress.seconds:.1f} s, {progress.size / 1e6:.1f} MB"
    return f"{waiting}{written}{dropped}; Ctrl-C ends it"


def _pre_trigger(rig: RigGrabber, options: argparse.Namespace, stack: ExitStack) -> PreTriggerBuffer:
    """Return a buffer of the last seconds, which is released by what `--on` names."""
    from grabbergui.core.frame_queue import FrameSink
    from grabbergui.recording.pre_trigger import PreTriggerBuffer

    buffer = PreTriggerBuffer(rig, options.before, AFTER if options.after is None else options.after)
    stack.callback(buffer.close)
    for what in options.on:
        if what == "key":
            threading.Thread(target=_trigger_by_key, args=(buffer,), name="key", daemon=True).start()
        elif what.startswith("level:"):
            level = part(what.removeprefix("level:"))
            sink = FrameSink(rig, LevelTrigger(level, buffer.trigger).look, name="level")
            stack.callback(sink.stop)
            sink.start()
        else:
            if not (having := rig.enable_event(what)):
                raise UsageError(
                    f"--on {what}: no camera has this event; `grabbergui events SOURCE` lists them"
                )
            for name in having:
                rig.cameras[name].event_received.connect(
                    lambda event, what=what: buffer.trigger() if event.name == what else None
                )
    return buffer


def _occasion(text: str) -> str:
    """Check what `--on` names, as far as that is known before a camera is open."""
    if text.startswith("level:"):
        part(text.removeprefix("level:"))
    return text


def _trigger_by_key(buffer: PreTriggerBuffer) -> None:
    for _ in sys.stdin:
        buffer.trigger()


class LevelTrigger:
    """Calls a function when the first image gets brighter than a level."""

    def __init__(self, level: float, trigger: Callable[[], object]) -> None:
        """`level` is a part of white."""
        self._level = level
        self._trigger = trigger
        self._bright = True

    def look(self, frame: Frame) -> None:
        """Look at the next frame."""
        bright = float(frame.mono()[::8, ::8].mean()) / 255 > self._level
        if bright and not self._bright:
            self._trigger()
        self._bright = bright


def _serve(options: argparse.Namespace) -> int:
    from grabbergui.rig.served_cameras import ServedCameras

    if not (options.yarp or options.ros2):
        raise UsageError("rig serve on what? Add --yarp /PORT or --ros2 /NAME")
    with stop_on_signals() as stop, ExitStack() as stack:
        rig = _opened(options.file, stack)
        rig.start()
        served = ServedCameras(rig)
        stack.callback(served.close)
        served.start()
        for name, camera in served.cameras.items():
            if options.yarp:
                from grabbergui.net.yarp.os.name_client import NameClient
                from grabbergui.net.yarp.server import YarpGrabberServer

                names = NameClient.find(options.nameserver)
                stack.enter_context(YarpGrabberServer(camera, f"{options.yarp}/{name}", names=names))
            if options.ros2:
                from grabbergui.net.ros2.server import Ros2GrabberServer

                stack.enter_context(Ros2GrabberServer(camera, f"{options.ros2}/{name}", frame_id=name))
        stack.enter_context(supervised(rig.statistics))
        uris = [f"yarp:{options.yarp}/{name}" for name in served.cameras if options.yarp]
        uris += [f"ros2:{options.ros2}/{name}" for name in served.cameras if options.ros2]
        print_line(f"serving {options.file} as {', '.join(uris)}; Ctrl-C ends it", flush=True)
        stop.wait()
    return 0
