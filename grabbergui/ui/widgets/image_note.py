"""A note over the image: why none is shown."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtWidgets import QBoxLayout, QFrame, QLabel, QWidget

from grabbergui.models.diagnosis import Stage
from grabbergui.models.language import translate
from grabbergui.models.markup import Markup, joined, markup
from grabbergui.models.messages import Offer
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_rich, set_tooltip
from grabbergui.ui.widgets.labels import restyle
from grabbergui.ui.widgets.messages import fill_offers


class ImageNote(QFrame):
    """Shows why there is no image, the remedy, buttons for it, and the stage at which the image is lost."""

    summaryLabel: QLabel
    adviceLabel: QLabel
    offersLayout: QBoxLayout
    stageLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("image_note", self)
        self.hide()

    def heightForWidth(self, width: int) -> int:
        """Return the height for a width; the buttons are one below the other where they need it."""
        buttons = [item.widget() for item in map(self.offersLayout.itemAt, range(self.offersLayout.count()))
                   if item is not None]  # fmt: skip
        needed = sum(button.sizeHint().width() + self.offersLayout.spacing() for button in buttons if button)
        margins = self.contentsMargins() if (around := self.layout()) is None else around.contentsMargins()
        wide = needed <= width - margins.left() - margins.right()
        across, below = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self.offersLayout.setDirection(across if wide else below)
        return super().heightForWidth(width)

    def setNote(
        self, summary: str, advice: str = "", stage: Stage | None = None, offers: Sequence[Offer] = ()
    ) -> None:
        """Show a note; with no summary, none. `stage` is where the image is lost, `offers` are buttons."""
        self.summaryLabel.setText(summary)
        self.adviceLabel.setText(advice)
        self.adviceLabel.setVisible(bool(advice))
        fill_offers(self.offersLayout, offers)
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
