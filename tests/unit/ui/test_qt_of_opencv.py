"""OpenCV's packages with windows set Qt's variables when they are loaded, for a Qt that PyQt5 is not."""

import os

import pytest

from grabbergui.ui.application import forget_qt_of_opencv


@pytest.mark.parametrize(
    ("path", "kept"),
    [
        ("/usr/lib/python3/site-packages/cv2/qt/plugins", False),
        ("/opt/qt5/plugins", True),
    ],
)
def test_only_the_plugins_of_opencv_are_forgotten(monkeypatch, path, kept):
    monkeypatch.setenv("QT_QPA_PLATFORM_PLUGIN_PATH", path)
    forget_qt_of_opencv()
    assert ("QT_QPA_PLATFORM_PLUGIN_PATH" in os.environ) is kept
