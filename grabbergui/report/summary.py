"""The contents of a report, for its reader and for the user who is about to write it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from grabbergui.driver.twin.report_file import CameraReport


def contents(report: CameraReport, *, names_kept: bool) -> list[str]:
    """Return a line for each part of the report."""
    return ["".join(c if c.isprintable() else "?" for c in line) for line in _lines(report, names_kept)]


def file_name(report: CameraReport) -> str:
    """Return a name for the file; the model's name comes from the camera, so only a few characters stay."""
    plain = "".join(c if c.isascii() and c.isalnum() else "-" for c in report.info.model).strip("-")[:40]
    return f"report-{plain or 'camera'}-{time.strftime('%Y%m%d-%H%M%S')}.zip"


def with_readme(report: CameraReport, *, names_kept: bool) -> CameraReport:
    """Return the report with a text for its reader."""
    parts = "\n".join(f"- {line}" for line in contents(report, names_kept=names_kept))
    text = (
        f"Report of a camera, made by grabbergui {report.made.get('grabbergui', '')}.\n\n{parts}\n\n"
        "`grabbergui twin:FILE.zip` opens it as a simulated camera,\n"
        "`grabbergui simulate --gige --twin FILE.zip` serves that on the network.\n"
    )
    return replace(report, readme=text)


def _lines(report: CameraReport, names_kept: bool) -> Iterator[str]:
    info, stream = report.info, report.stream
    yield f"the camera: {' '.join(filter(None, (info.vendor, info.model, info.version)))} at {info.uri}"
    size = len(report.description)
    yield f"its description, {size} bytes" if size else "no description"
    known = (*report.bootstrap, *report.registers)
    if known:
        refused = sum(bool(each.failure) for each in known)
        yield f"{len(known)} registers as they were read, {refused} of which the camera refused"
    if report.features:
        yield f"{len(report.features)} features with their values"
    if stream.packet_tests:
        arrived = ", ".join(str(test.size) for test in stream.packet_tests if test.arrived) or "none"
        yield f"tests of packet sizes; those that arrived: {arrived}"
    if stream.started:
        yield f"headers and times of {len(stream.frames)} frames, and the stream's counters"
    yield f"pixels of {len(report.pixels)} frames" if report.pixels else "no pixels"
    answers = report.computer.get("discovery", [])
    yield f"the network interfaces, and {len(answers)} answers of GigE Vision cameras to discovery"
    yield f"{len(report.computer.get('doctor', []))} findings of `grabbergui doctor`, versions, and the log"
    for problem in report.problems:
        yield f"a problem: {problem}"
    if names_kept:
        yield "names, serial numbers, MAC and IP addresses AS THEY ARE"
    else:
        yield "names, serial numbers, MAC and IP addresses replaced by stand-ins"
