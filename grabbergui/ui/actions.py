"""Actions that are unavailable say why."""

from __future__ import annotations

from dataclasses import dataclass

from PyQt5.QtWidgets import (
    QAction,
    QWidget,
)

from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.shown_text import add_to_tooltip, tooltip_of

_PURPOSE = "purpose"
"The property of an action or button that keeps the tooltip it has while it is available."


@dataclass(frozen=True)
class _Purpose:
    tooltip: str
    "A `Markup` if it is rich; as a property of its own it would become a plain text."


def set_available(action: QAction | QWidget, reason: Unavailable | str | None) -> None:
    """Enable an action or a control, or disable it and give the reason, if any, in its tooltip."""
    purpose = action.property(_PURPOSE)
    if purpose is None:
        purpose = _Purpose(tooltip_of(action))
        action.setProperty(_PURPOSE, purpose)
    reason = reason.text if isinstance(reason, Unavailable) else reason or ""
    action.setEnabled(not reason)
    add_to_tooltip(action, purpose.tooltip, reason)
