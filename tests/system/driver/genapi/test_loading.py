"""Large descriptions are parsed by a process of their own, which may die at any moment without a trace."""

import logging
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from genicam import genapi

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi import loading, parse_cache
from grabbergui.driver.genapi.loading import LARGE_XML, load
from grabbergui.driver.genapi.parse_cache import Known
from grabbergui.driver.genapi.vetting import vetted
from patience import PROGRAM

XML = (Path(__file__).parents[3] / "data" / "genapi" / "test_camera.xml").read_text()
LARGE = XML.replace("</RegisterDescription>", f"<!--{' ' * LARGE_XML}--></RegisterDescription>")
VARIABLE = parse_cache._cache.name
FOLDER = parse_cache._cache.folder


def semaphores() -> set[str]:
    return {path.name for path in Path("/dev/shm").glob("sem.*GenICam_XML")}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch) -> Path:
    """The user's cache, with nothing in it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "grabbergui" / "descriptions"


@pytest.fixture
def runs(monkeypatch):
    """The files in the cache after each process that parsed."""
    seen, really = [], parse_cache._ParserProcess.parse

    def parse(parser, text):
        done = really(parser, text)
        seen.append([path.suffix for path in FOLDER.iterdir()])
        return done

    monkeypatch.setattr(parse_cache._ParserProcess, "parse", parse)
    return seen


def ending_with(monkeypatch, ended_by: int) -> None:
    """Let the process that parses end itself so, once it has parsed."""
    ending = f"import os; os.kill(os.getpid(), {ended_by})\n"
    monkeypatch.setattr(parse_cache, "_PARSE", parse_cache._PARSE + ending)


def test_a_full_disk_keeps_no_known_description_from_loading():
    load(LARGE)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))
    try:
        assert load(LARGE).has_node("Width")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("xml, processes", [(XML, 0), (LARGE, 1)], ids=["small", "large"])
def test_only_a_large_description_is_parsed_elsewhere(runs, xml, processes):
    nodes = load(xml)

    assert nodes.has_node("Width")
    assert runs == [[".bin"]] * processes
    assert not FOLDER.exists()


def test_without_that_process_it_is_parsed_here(monkeypatch, caplog):
    caplog.set_level(logging.INFO)
    monkeypatch.setattr(parse_cache.sys, "executable", "/does/not/exist")

    assert load(LARGE).has_node("Width")
    assert "parsed by this process" in caplog.text
    assert not FOLDER.exists()


def test_without_shared_memory_it_is_parsed_here_and_the_log_names_it(monkeypatch, caplog):
    caplog.set_level(logging.INFO)
    monkeypatch.setattr(parse_cache, "MEMORY", Path("/dev/no-shm"))

    assert load(LARGE).has_node("Width")
    assert "/dev/no-shm cannot be written" in caplog.text


def test_a_process_that_ends_half_way_leaves_no_half_result(monkeypatch):
    really = parse_cache._ParserProcess.parse

    def parse(parser, text):
        really(parser, text)
        (result,) = FOLDER.glob("*.bin")
        result.write_bytes(result.read_bytes()[:1000])
        return False

    monkeypatch.setattr(parse_cache._ParserProcess, "parse", parse)

    assert load(LARGE).has_node("Width")


@pytest.mark.parametrize(
    ("ended_by", "reason"),
    [(signal.SIGSEGV, "GenApi crashes on it"), (signal.SIGXCPU, "GenApi needs more than 10 s")],
)
def test_what_kills_the_other_process_does_not_get_into_this_one(monkeypatch, ended_by, reason):
    ending_with(monkeypatch, ended_by)

    with pytest.raises(RemoteProtocolError, match=reason):
        load(LARGE)


def test_a_process_that_somebody_kills_does_not_spoil_the_description(monkeypatch):
    ending_with(monkeypatch, signal.SIGKILL)

    assert load(LARGE).has_node("Width")


def test_a_large_description_that_is_broken_is_refused_as_a_small_one_is():
    for xml in (XML, LARGE):
        with pytest.raises((genapi.GenericException, RuntimeError), match=r"(?i)xml"):
            load(xml.replace("Integer", "Intruder"))
    assert not FOLDER.exists()


@pytest.mark.parametrize("xml", [XML, LARGE], ids=["small", "large"])
def test_loading_leaves_no_semaphore(xml):
    before = semaphores()

    load(xml)

    assert semaphores() <= before


def test_a_known_description_is_neither_vetted_nor_parsed_again(runs, monkeypatch):
    load(LARGE)
    monkeypatch.setattr(parse_cache, "vetted", None)

    assert load(LARGE).has_node("Width")
    assert len(runs) == 1


def test_one_that_differs_in_a_letter_is_another(runs):
    load(LARGE)
    load(LARGE.replace("<!-- ", "<!--.", 1))

    assert len(runs) == 2


@pytest.mark.parametrize("kept", ["description.xml", "result", "digest"])
def test_what_was_kept_and_is_spoilt_is_made_again(cache, runs, kept):
    load(LARGE)
    (entry,) = cache.iterdir()
    (entry / kept).write_bytes((entry / kept).read_bytes()[:-1])

    assert load(LARGE).has_node("Width")
    assert len(runs) == 2
    assert load(LARGE).has_node("Width")
    assert len(runs) == 2


def test_a_cache_that_others_can_write_to_is_not_used(cache, runs):
    load(LARGE)
    (entry,) = cache.iterdir()
    entry.chmod(0o777)

    assert load(LARGE).has_node("Width")
    assert len(runs) == 2


def test_what_genapi_cannot_load_is_kept_no_longer(cache, monkeypatch):
    """Otherwise that camera could not be opened until somebody removes the file."""
    load(LARGE)
    with monkeypatch.context() as patch:
        patch.setattr(parse_cache, "_read", lambda entry: Known("<no description", "0x00.bin", b""))
        with pytest.raises((genapi.GenericException, RuntimeError)):
            load(LARGE)

    assert not any(cache.iterdir())
    assert load(LARGE).has_node("Width")


def test_the_cache_keeps_what_was_used_last(cache, monkeypatch):
    monkeypatch.setattr(parse_cache, "MOST_ENTRIES", 2)
    texts = [f"description {number}" for number in range(3)]
    for age, text in zip((20, 30, 0), texts, strict=True):
        parse_cache.keep(text, Known(text, "0x00.bin", b""))
        entry = cache / parse_cache._key(text)
        os.utime(entry, (time.time() - age, time.time() - age))
    parse_cache.keep(texts[2], Known(texts[2], "0x00.bin", b""))

    def kept(text: str) -> bool:
        with parse_cache.known_description(text) as found:
            return found is not None

    assert [kept(text) for text in texts] == [True, False, True]


def test_a_semaphore_that_a_dead_process_holds_does_not_stop_a_known_description(cache):
    load(LARGE)
    (entry,) = cache.iterdir()
    name = (entry / "digest").read_text().split()[1]
    semaphore = parse_cache._semaphore_of(Path(name))
    semaphore.write_bytes(bytes(32))  # taken
    command = [sys.executable, "-c", f"from {loading.__name__} import load; load(open(0).read())"]
    try:
        assert subprocess.run(command, input=LARGE, text=True, timeout=PROGRAM).returncode == 0
    finally:
        semaphore.unlink(missing_ok=True)


def test_a_semaphore_of_another_user_does_not_stop_a_known_description(cache, monkeypatch):
    """Its name could be seen in /dev/shm. It cannot be removed, and GenApi would wait for it."""
    load(LARGE)
    really = parse_cache._semaphore_of
    (name,) = ((entry / "digest").read_text().split()[1] for entry in cache.iterdir())

    def semaphore_of(result):
        semaphore = really(result)
        if result.name != name:
            return semaphore
        return Path("/proc/1/status")  # nobody can remove it

    monkeypatch.setattr(parse_cache, "_semaphore_of", semaphore_of)
    with parse_cache.parsed(LARGE) as text:
        assert text.startswith(vetted(LARGE)), "parsed again, with a semaphore of its own"
    (entry,) = cache.iterdir()
    assert (entry / "digest").read_text().split()[1] != name, "and kept in place of the one that is blocked"


def test_a_semaphore_that_a_dead_process_holds_stops_nobody(tmp_path):
    """Before, this waited for ever: GenApi's semaphore has the same name for everybody."""
    description = tmp_path / "description.xml"
    description.write_text(LARGE)

    def run(script: str) -> None:
        command = [sys.executable, "-c", f"import sys; xml = open(sys.argv[1]).read(); {script}", description]
        done = subprocess.run(command, env={**os.environ, VARIABLE: str(tmp_path)}, timeout=PROGRAM)
        assert done.returncode == 0

    run("from genicam import genapi; genapi.NodeMap().load_xml_from_string(xml)")
    (result,) = tmp_path.glob("*.bin")
    semaphore = parse_cache._semaphore_of(result)
    content = bytearray(semaphore.read_bytes())
    content[0] = 0  # taken
    semaphore.write_bytes(content)
    try:
        run(f"from {loading.__name__} import load; load(xml)")
    finally:
        semaphore.unlink()


def test_what_a_killed_process_left_behind_is_removed():
    folder = Path(tempfile.mkdtemp(prefix=parse_cache._PREFIX))
    result = folder / "0xb6b3057400000000.bin"
    result.touch()
    semaphore = parse_cache._semaphore_of(result)
    semaphore.touch()

    parse_cache.remove_abandoned()
    assert folder.exists()  # it may be in use

    old = time.time() - 2 * parse_cache.ABANDONED
    os.utime(folder, (old, old))
    fifo = folder.with_name(f"{parse_cache._PREFIX}0{os.getpid()}")
    os.mkfifo(fifo)  # of another user: before, this waited for ever
    try:
        os.utime(fifo, (old, old))
        parse_cache.remove_abandoned()
    finally:
        fifo.unlink()
    assert not folder.exists()
    assert not semaphore.exists()
