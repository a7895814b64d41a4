"""Opening a source by its kind."""

import pytest

from grabbergui import sources
from grabbergui.core.errors import SourceUnavailableError


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "import no_such_package_anywhere",
            r"v4l2: sources cannot be used: the package no_such_package",
        ),
        ("None.attribute", r"v4l2: .* installed but broken \(AttributeError: .*install grabbergui again"),
        (
            "raise OSError('libX.so: wrong ELF class')",
            r"v4l2: .* broken \(OSError: libX\.so: wrong ELF class\)",
        ),
    ],
)
def test_a_kind_whose_package_cannot_be_loaded_is_named_with_the_reason(text, message, tmp_path, monkeypatch):
    (tmp_path / "kind_of_source_under_test.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(sources.MODULES, "v4l2", "kind_of_source_under_test")
    with pytest.raises(SourceUnavailableError, match=message):
        sources.create("v4l2:")
    assert sources.discover_kind("v4l2") == []


@pytest.mark.parametrize("name", ["lü 50%20 #1", "what?.tiff", "a=b?c=d"])
def test_a_file_may_be_typed_as_it_is_called(tmp_path, name):
    """Before, the program looked for "lü 50  #1" when "lü 50%20 #1" was typed."""
    path = tmp_path / name
    path.mkdir()
    assert sources.parse(f"file:{path}").name == str(path)
    assert sources.parse(str(sources.parse(f"file:{path}"))).name == str(path)
