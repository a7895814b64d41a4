"""The look that all dialogs have in common: margins, spacing, the button that acts.

A dialog's buttons are in its last row: others, then the one that acts (*primary*), then *Close* or *Cancel*.
In a wizard, *Next* is last. `load_form` calls `dress_dialog` for dialogs of forms; questions are
`shown_text.question_box`.
"""

from __future__ import annotations

from PyQt5.QtWidgets import QDialog, QPushButton

from grabbergui.ui.widgets.labels import restyle

MARGIN, SPACING = 12, 6
"Pixels around the content, and between its parts."


def dress_dialog(dialog: QDialog, primary: QPushButton | None = None) -> None:
    """Give a dialog, once it has its layout, the common margins; `primary` acts. Forms set that property.

    A layout without margins, whose content reaches the edge, keeps none.
    """
    layout = dialog.layout()
    if layout is not None:
        layout.setSpacing(SPACING)
        if layout.contentsMargins().left() > 0:
            layout.setContentsMargins(MARGIN, MARGIN, MARGIN, MARGIN)
    if primary is not None:
        restyle(primary, "primary", True)
