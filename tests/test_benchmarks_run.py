"""Benchmarks measure what is there: the short ones run, so that they follow the code they measure."""

import pytest

pytest.importorskip("benchmarks", reason="benchmarks/ is found from the checkout: python -m pytest")

from benchmarks import end_to_end, sim_render, yarp_ports


def test_the_sensor_is_measured():
    section = sim_render.measure(["--formats", "Mono8"])

    ((name, *_, share),) = section.tables[0].rows
    assert name == "Mono8" and share.endswith("%")
    assert [goal.measured for goal in section.goals] == [share]


def test_yarp_streams_and_requests_are_measured():
    options = ["--sizes", "640×480", "--carriers", "fast_tcp", "--seconds", "0.2", "--rounds", "1"]

    section = yarp_ports.measure(options)

    streams, ages, trips = (table.rows for table in section.tables)
    ours = next(row for row in streams if row[2] == "ours → ours")
    assert int(ours[3]) > 0
    assert next(row for row in ages if row[0] == "ours → ours")[1] != "nan ms"
    assert float(next(row for row in trips if row[0] == "ours asks ours")[1].removesuffix(" ms")) > 0


def test_the_way_from_the_camera_to_a_reader_is_measured(monkeypatch):
    monkeypatch.setattr(end_to_end, "has_aravis_camera", lambda: False)
    monkeypatch.setattr(end_to_end, "SETTLING", 0.2)

    section = end_to_end.measure(["--seconds", "0.5", "--rounds", "1"])

    server, rate, *_, per_frame = section.tables[0].rows[0]
    assert (server, section.lacking) == (end_to_end.OURS, "AravisCamera")
    assert float(rate) > 0 and float(per_frame.removesuffix(" ms")) > 0
