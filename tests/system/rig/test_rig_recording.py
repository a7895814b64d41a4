"""Recordings of a rig after kill -9 and with a slow disk: every set is accounted for."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import pytest

from grabbergui import sources
from grabbergui.recording.mcap_writer import McapWriter
from grabbergui.recording.recorder import RecordingLimits
from grabbergui.rig import rig_file, source
from grabbergui.rig.recording import RigRecording, begin
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from grabbergui.rig.set_frame import SetFrame
from patience import PATIENCE, until

FAST = "sim:?width=64&height=48&fps=100&exposure=1000"
NAMES = ("left", "right", "top")
RIG = RigEntry(
    {name: CameraEntry(f"{FAST}&serial={name}") for name in NAMES}, trigger=TriggerEntry("software", 25)
)


def indices_of(path: Path) -> list[int]:
    """Read every set of a recording; return their numbers. Each has all the images that it names."""
    recording = RigRecording(path)
    try:
        found = []
        for place in range(len(recording.times_ns)):
            frame = recording.frame(place, recording.times_ns[place])
            assert isinstance(frame, SetFrame)
            assert set(frame.images) | set(frame.images.missing) == set(NAMES)
            assert all(image.raw().shape == (48, 64) for image in frame.images.values())
            found.append(frame.images.index)
        return found
    finally:
        recording.close()


def test_a_killed_recording_in_segments_has_every_set_once(tmp_path: Path) -> None:
    file = tmp_path / "three.yaml"
    rig_file.write(file, RIG)
    words = ("rig", "record", str(file), "--out", str(tmp_path / "day.mcap"), "--segment", "1")
    with subprocess.Popen([sys.executable, "-m", "grabbergui", *words], stdout=subprocess.DEVNULL) as program:
        third = tmp_path / "day.0003.mcap"
        until(lambda: third.exists() and third.stat().st_size > 60_000, "the third segment has images")
        program.send_signal(signal.SIGKILL)
    segments = sorted(tmp_path.glob("day.*.mcap"))
    indices = [index for segment in segments for index in indices_of(segment)]
    assert len(segments) >= 3 and len(indices_of(third)) >= 2
    assert indices == list(range(indices[0], indices[0] + len(indices)))
    player = sources.create(f"rig:{third}")
    try:
        player.open()
        frames = player.open_queue(4)
        player.start()
        assert isinstance(frames.get(PATIENCE), SetFrame)
    finally:
        player.close()


def test_what_a_slow_disk_drops_is_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = McapWriter.write
    monkeypatch.setattr(McapWriter, "write", lambda self, frame: (time.sleep(0.2), write(self, frame)))
    rig = source.of_entry(RIG)
    rig.open()
    try:
        recorder = begin(rig, tmp_path / "slow.mcap", RecordingLimits(frames=24))
        recorder.start()
        rig.start()
        assert recorder.wait(PATIENCE)
    finally:
        rig.close()
    progress, indices = recorder.progress, indices_of(tmp_path / "slow.mcap")
    assert progress.frames == len(indices) == 24 and progress.dropped > 0
    gaps = sum(b - a - 1 for a, b in pairwise(indices))
    assert 0 < gaps <= progress.dropped
