from pathlib import Path

from benchmarks import __main__ as all_benchmarks
from benchmarks import _faults, reliability
from benchmarks._faults import Outcome, document, keep, kept


def outcome(**changes):
    return Outcome(
        **{"done": "pulled", "times": "20", "lost": "3", "well_after": "1 s", "machine": "m"} | changes
    )


def test_the_page_has_a_row_per_fault_and_marks_what_did_not_hold(tmp_path, monkeypatch):
    monkeypatch.setattr(_faults, "FAULTS", {})
    _faults.fault("Cables")(lambda: outcome())
    for name in ("first_fault", "second_fault", "never_tried"):
        function = lambda: outcome()  # noqa: E731
        function.__name__ = name
        _faults.fault("Strangers")(function)
    keep("first-fault", outcome(), tmp_path)
    keep("second-fault", outcome(done="cut", survived=False), tmp_path)
    keep("second-fault", outcome(done="cut again", survived=False), tmp_path)

    page = document(kept(tmp_path))

    assert page == document(kept(tmp_path))
    assert "**Not survived: second-fault.**" in page
    assert "| pulled | 20 | 3 | 1 s |\n| cut again | 20 | 3 | 1 s **(failed)** |" in page
    assert "Cables" not in page, "nothing was tried there"


def test_a_machine_is_named_once_with_its_loads(monkeypatch):
    monkeypatch.setattr(_faults, "FAULTS", dict.fromkeys("abc", ("Strangers", outcome)))
    loads = {
        "a": "m, load average 3.5 before; others kept it busy",
        "b": "m, load average 1.0 before",
        "c": "n",
    }
    page = document({name: outcome(machine=machine) for name, machine in loads.items()})
    assert "Measured on m, load average 1 to 3.5 before; n.\n" in page


def test_the_page_is_what_the_kept_outcomes_give():
    reliability.main(["--list"])
    assert Path(_faults.DOCUMENT).read_text(encoding="utf-8") == document(kept())
    assert set(kept()) <= set(_faults.FAULTS), "an outcome of a fault that is gone"


def test_the_page_is_the_same_whichever_module_was_imported_first(capsys):
    reliability.main(["--list"])
    listed = capsys.readouterr().out.split()
    assert len(listed) > 10
    chapters = list(dict.fromkeys(_faults.FAULTS[name][0] for name in listed))
    backwards = dict(reversed(_faults.FAULTS.items()))
    _faults.FAULTS.clear()
    _faults.FAULTS.update(backwards)
    try:
        reliability.main(["--list"])
        again = capsys.readouterr().out.split()
        assert list(dict.fromkeys(_faults.FAULTS[name][0] for name in again)) == chapters
    finally:
        faults = dict(_faults.FAULTS)
        _faults.FAULTS.clear()
        _faults.FAULTS.update({name: faults[name] for name in listed})


def test_the_page_is_written_by_the_program_for_all_benchmarks(tmp_path, monkeypatch):
    monkeypatch.setattr(reliability, "DOCUMENT", tmp_path / "reliability.md")
    monkeypatch.setattr("sys.argv", ["benchmarks", "reliability", "--only-write"])

    all_benchmarks.main()

    assert "Measured on" in (tmp_path / "reliability.md").read_text()
