"""Widgets whose look depends on what they say."""

from __future__ import annotations

from PyQt5.QtWidgets import QWidget


def restyle(widget: QWidget, name: str, value: object) -> None:
    """Set a property that the style sheet knows, such as `tone`, and apply the style sheet again."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        # A style sheet looks at properties only when a widget is polished.
        if (style := widget.style()) is not None:
            style.unpolish(widget)
            style.polish(widget)
