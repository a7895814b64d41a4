"""A note over the image: why none is shown."""

from __future__ import annotations

from PyQt5.QtWidgets import (
    QFrame,
    QLabel,
    QWidget,
)

from grabbergui.models.diagnosis import Stage
from grabbergui.models.language import translate
from grabbergui.models.markup import Markup, joined, markup
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_rich, set_tooltip
from grabbergui.ui.widgets.labels import restyle


class ImageNote(QFrame):
    """Shows why there is no image, the remedy, and the stage at which the image is lost."""

    summaryLabel: QLabel
    adviceLabel: QLabel
    stageLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("image_note", self)
        self.hide()

    def setNote(self, summary: str, advice: str = "", stage: Stage | None = None) -> None:
        """Show a note; with no summary, none. `stage` is where the image is lost."""
        self.summaryLabel.setText(summary)
        self.adviceLabel.setText(advice)
        self.adviceLabel.setVisible(bool(advice))
        set_rich(self.stageLabel, _way(stage) if stage is not None else Markup())
        self.stageLabel.setVisible(stage is not None)
        self.setAccessibleName(f"{summary} {advice}")
        set_tooltip(self, f"{summary}\n{advice}".strip())  # in a low window its end may be cut off
        restyle(self, "tone", "info" if stage is None else "busy")
        self.setVisible(bool(summary))


def _way(end: Stage) -> Markup:
    """Return the stages: those passed, the one that fails, which is marked, and the rest."""
    stages = list(Stage)
    parts = []
    for index, stage in enumerate(stages):
        before, at = index < stages.index(end), stage is end
        mark = "✓" if before else "✗" if at else "·"
        text = f"{mark} {_stage_name(stage)}"
        parts.append(markup("<b>{0}</b>", text) if at else text)
    return joined(parts, "&nbsp;&nbsp; ")


def _stage_name(stage: Stage) -> str:
    names = {
        Stage.CONTROL: translate("ImageNote", "control"),
        Stage.PACKETS: translate("ImageNote", "packets"),
        Stage.FRAMES: translate("ImageNote", "frames"),
        Stage.CONVERSION: translate("ImageNote", "conversion"),
        Stage.DISPLAY: translate("ImageNote", "display"),
    }
    return names[stage]
