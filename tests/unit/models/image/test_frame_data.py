"""What a frame carries beside its pixels, as rows of text."""

import time
from dataclasses import replace

import numpy as np

from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.pfnc import by_name
from grabbergui.models.image.frame_data import MOST_TEXT, frame_rows

FRAME = Frame(np.zeros(12, np.uint8), 4, 3, by_name("Mono8"), frame_id=7, timestamp_ns=1_500_000_000)


def test_number_times_size_and_chunks_are_listed():
    moment = time.mktime((2026, 11, 28, 13, 14, 15, 0, 0, -1))
    frame = replace(
        FRAME,
        received_ns=int(moment) * 1_000_000_000 + 123_456_789,
        chunks={"ChunkGain": 6.5, "ChunkExposureTime": 10000.0},
    )
    rows = dict(frame_rows(frame))
    assert rows["Frame id"] == "7"
    assert rows["Exposed or received at"] == "2026-11-28 13:14:15.123456"
    assert rows["Camera's clock"] == "1.500000 s"
    assert (rows["Size"], rows["Pixel format"], rows["Payload"]) == ("4 × 3", "Mono8", "12 bytes")
    assert rows["Completeness"] == "complete"
    assert list(rows)[-2:] == ["ChunkExposureTime", "ChunkGain"], "by name"
    assert (rows["ChunkExposureTime"], rows["ChunkGain"]) == ("10000", "6.5")


def test_what_is_not_known_is_a_dash_and_what_is_missing_is_counted():
    frame = replace(FRAME, timestamp_ns=0, status=FrameStatus.INCOMPLETE, missing_bytes=1400)
    rows = dict(frame_rows(frame))
    assert rows["Camera's clock"] == rows["Exposed or received at"] == "–"
    assert rows["Completeness"] == "1400 bytes are missing"


def test_a_long_chunk_is_shortened():
    rows = dict(frame_rows(replace(FRAME, chunks={"ChunkCounters": b"x" * 10_000})))
    assert len(rows["ChunkCounters"]) == MOST_TEXT
