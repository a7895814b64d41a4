"""Large descriptions are parsed by a process of their own, and nothing is left of it."""

import logging
import os
import subprocess
from pathlib import Path

import pytest
from genicam import genapi

from grabbergui.driver.genapi import loading

XML = (Path(__file__).parents[2] / "data" / "genapi" / "test_camera.xml").read_text()
LARGE = XML.replace("</RegisterDescription>", f"<!--{' ' * loading.LARGE}--></RegisterDescription>")


@pytest.fixture
def runs(monkeypatch):
    """What the cache held after each process that parsed."""
    seen, really = [], subprocess.run

    def run(*args, **kwargs):
        completed = really(*args, **kwargs)
        seen.append([path.suffix for path in loading._cache.iterdir()])
        return completed

    monkeypatch.setattr(loading.subprocess, "run", run)
    return seen


def test_the_installed_genapi_looks_for_its_cache_where_we_say():
    assert os.environ[loading._cache_variable()] == str(loading._cache)


@pytest.mark.parametrize("xml, processes", [(XML, 0), (LARGE, 1)], ids=["small", "large"])
def test_only_a_large_description_is_parsed_elsewhere(runs, xml, processes):
    nodes = loading.load(xml)

    assert nodes.has_node("Width")
    assert runs == [[".bin"]] * processes
    assert not loading._cache.exists()


def test_without_that_process_it_is_parsed_here(monkeypatch, caplog):
    caplog.set_level(logging.DEBUG)
    monkeypatch.setattr(loading.sys, "executable", "/does/not/exist")

    assert loading.load(LARGE).has_node("Width")
    assert "parsed by this process" in caplog.text
    assert not loading._cache.exists()


def test_a_process_that_ends_half_way_leaves_no_half_result(monkeypatch):
    really = subprocess.run

    def run(*args, **kwargs):
        really(*args, **kwargs)
        (result,) = loading._cache.glob("*.bin")
        result.write_bytes(result.read_bytes()[:1000])
        raise subprocess.TimeoutExpired("python", 5)

    monkeypatch.setattr(loading.subprocess, "run", run)

    assert loading.load(LARGE).has_node("Width")


def test_a_large_description_that_is_broken_is_refused_as_a_small_one_is():
    with pytest.raises((genapi.GenericException, RuntimeError), match=r"(?i)xml"):
        loading.load(LARGE.replace("<Integer", "<Intruder"))
    assert not loading._cache.exists()


def test_a_vendors_cache_is_left_alone(monkeypatch):
    monkeypatch.setenv(loading._cache_variable(), "/opt/vendor/cache")

    assert loading._private_cache() is None
    assert os.environ[loading._cache_variable()] == "/opt/vendor/cache"
