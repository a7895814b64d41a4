"""Text as it is, and numbers that are typed as text."""

from dataclasses import replace

from PyQt5.QtCore import Qt
from sample_features import ADDRESS, TEXT


def test_text_is_typed(take, qtbot):
    hand = take(TEXT)
    line = hand.editor.line
    assert line.text() == "left"
    qtbot.keyClicks(line, "XY")
    hand.editor.setFeature(replace(TEXT, value="other"))
    assert hand.holds == ["start"]
    qtbot.keyClick(line, Qt.Key_Return)
    assert len(hand.values) == 1
    assert "XY" in hand.values[0]
    assert hand.holds == ["start", "finish"]
    qtbot.keyClicks(line, "Z" * 50)
    qtbot.keyClick(line, Qt.Key_Escape)
    assert line.text() == "other"
    assert len(hand.values) == 1


def test_an_address_is_typed_as_an_address(take, qtbot):
    hand = take(ADDRESS)
    line = hand.editor.line
    assert line.text() == "192.168.0.10"
    line.selectAll()
    qtbot.keyClicks(line, "10.0.0.1")
    qtbot.keyClick(line, Qt.Key_Return)
    line.selectAll()
    qtbot.keyClicks(line, "10.0.0.999")
    qtbot.keyClick(line, Qt.Key_Return)
    assert hand.values == [0x0A000001]
