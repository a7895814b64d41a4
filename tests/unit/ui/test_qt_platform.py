"""A platform that Qt cannot use is named with its variable; Qt would abort and advise to reinstall."""

import pytest
from PyQt5.QtCore import QSettings

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.ui.application import require_platform
from grabbergui.ui.preferences import Preferences


@pytest.mark.parametrize("value", ["", "offscreen", "offscreen:size=10x10", "nothing;offscreen", "minimal"])
def test_a_platform_that_qt_has_is_used(monkeypatch, value):
    monkeypatch.setenv("QT_QPA_PLATFORM", value)
    assert require_platform() is None


@pytest.mark.parametrize("value", ["cocoa", "nothing;neither"])
def test_a_platform_that_qt_lacks_is_named_with_its_variable(monkeypatch, value):
    monkeypatch.setenv("QT_QPA_PLATFORM", value)
    with pytest.raises(SourceUnavailableError, match=rf"QT_QPA_PLATFORM={value}: .* one of .*offscreen"):
        require_platform()


def test_a_platform_without_its_display_is_named(monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "xcb")
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(SourceUnavailableError, match="QT_QPA_PLATFORM=xcb needs a display, and DISPLAY"):
        require_platform()


def test_preferences_that_cannot_be_kept_name_their_file(tmp_path):
    (tmp_path / "file").write_text("no folder")
    nowhere = QSettings(str(tmp_path / "file" / "grabbergui.conf"), QSettings.Format.IniFormat)
    assert Preferences(nowhere).unwritable.endswith("file/grabbergui.conf")
    kept = QSettings(str(tmp_path / "grabbergui.conf"), QSettings.Format.IniFormat)
    assert Preferences(kept).unwritable == Preferences(None).unwritable == ""
