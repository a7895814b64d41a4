"""`make test` compiles what has changed, runs the slowest tests first, and fails when a test does."""

import os
import subprocess
import time
from pathlib import Path

import pytest

import isolation
import run_tests
import slowest


def test_a_failure_is_not_repeated_and_fails_the_run(tmp_path, monkeypatch):
    (tmp_path / "test_once.py").write_text(
        "from pathlib import Path\n\ndef test_it():\n    seen = Path(__file__).with_suffix('.seen')\n"
        "    if not seen.exists():\n        seen.touch()\n        raise AssertionError\n"
    )
    monkeypatch.setattr(run_tests, "OUTCOME", tmp_path / "outcome")
    monkeypatch.setenv("GRABBERGUI_TEST_WORKERS", "1")  # each loads all that tests share
    assert run_tests.main([str(tmp_path)]) != 0
    assert run_tests.main([str(tmp_path)]) == 0


def test_only_changed_modules_are_compiled_before_the_run(tmp_path, monkeypatch):
    for name in ("test_old.py", "test_new.py"):
        (tmp_path / name).write_text("def test_it():\n    assert True\n")
    monkeypatch.setattr(run_tests.os, "cpu_count", lambda: 1)
    started = []
    popen = subprocess.Popen
    monkeypatch.setattr(
        run_tests.subprocess,
        "Popen",
        lambda command, **more: started.append(command) or popen(command, **more),
    )
    run_tests.compile_tests([tmp_path])
    assert all(run_tests.is_compiled(tmp_path / name) for name in ("test_old.py", "test_new.py"))
    later = time.time() + 60
    os.utime(tmp_path / "test_new.py", (later, later))
    run_tests.compile_tests([tmp_path])
    assert [Path(name).name for name in started[1][7:]] == ["test_new.py"]
    assert len(started) == 2


def test_slow_tests_are_remembered_wherever_they_stand(tmp_path, monkeypatch):
    monkeypatch.setattr(slowest, "REMEMBERED", tmp_path / "slowest.txt")
    (tmp_path / "run.xml").write_text(
        "<testsuites><testsuite>"
        "<testcase classname='tests.unit.net.test_a' name='test_long[a b]' time='9.25'/>"
        "<testcase classname='tests.system.test_b' name='test_short' time='0.01'/></testsuite></testsuites>"
    )
    slowest.record(run_tests.durations(tmp_path / "run.xml"))
    assert slowest.remembered() == {"net/test_a::test_long[a b]": 9.2}


def test_a_report_with_a_file_name_in_latin_1_is_sent_to_the_process_that_began_the_run():
    gateway_base = pytest.importorskip("execnet.gateway_base")
    report = {
        "sections": [("Captured log call", "caf\udce9 µ")],
        "when": "call",
        "lineno": 3,
        "longrepr": None,
    }
    with pytest.raises(gateway_base.DumpError):
        gateway_base.dumps_internal(report)
    received = gateway_base.loads_internal(gateway_base.dumps_internal(isolation.sendable(report)))
    assert received == {**report, "sections": [("Captured log call", r"caf\udce9 µ")]}


def test_only_the_tier_that_never_waits_has_as_few_workers_as_cores():
    assert run_tests.never_waits(["-q", str(run_tests.UNIT), str(run_tests.UNIT / "core")])
    assert not run_tests.never_waits([str(run_tests.UNIT), str(run_tests.REPOSITORY / "tests" / "system")])
    assert not run_tests.never_waits(["-q"])
