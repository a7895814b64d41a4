"""A note in place of the picture: why there is none, and what to do."""

from __future__ import annotations

from PyQt5.QtCore import QCoreApplication
from PyQt5.QtWidgets import QFrame, QLabel, QWidget

from grabbergui.models.diagnosis import Stage
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.styled import restyle

translate = QCoreApplication.translate


class PictureNote(QFrame):
    """Says what hinders the picture, what to do, and how far it comes."""

    summaryLabel: QLabel
    adviceLabel: QLabel
    stageLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("picture_note", self)
        self.hide()

    def setNote(self, summary: str, advice: str = "", stage: Stage | None = None) -> None:
        """Show a note; with no summary, none. `stage` is where the picture's way ends."""
        self.summaryLabel.setText(summary)
        self.adviceLabel.setText(advice)
        self.adviceLabel.setVisible(bool(advice))
        self.stageLabel.setText(_way(stage) if stage is not None else "")
        self.stageLabel.setVisible(stage is not None)
        self.setAccessibleName(f"{summary} {advice}")
        restyle(self, "tone", "info" if stage is None else "busy")
        self.setVisible(bool(summary))


def _name(stage: Stage) -> str:
    names = {
        Stage.CONTROL: translate("PictureNote", "control"),
        Stage.PACKETS: translate("PictureNote", "packets"),
        Stage.FRAMES: translate("PictureNote", "frames"),
        Stage.CONVERSION: translate("PictureNote", "conversion"),
        Stage.DISPLAY: translate("PictureNote", "display"),
    }
    return names[stage]


def _way(end: Stage) -> str:
    """The stages up to the one that fails, which is marked, and those it keeps from happening."""
    stages = list(Stage)
    parts = []
    for index, stage in enumerate(stages):
        before, at = index < stages.index(end), stage is end
        mark = "✓" if before else "✗" if at else "·"
        text = f"{mark} {_name(stage)}"
        parts.append(f"<b>{text}</b>" if at else text)
    return "&nbsp;&nbsp; ".join(parts)
