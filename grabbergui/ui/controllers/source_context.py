"""The parameters that all controllers of the window share, so that each asks for the rest only."""

from __future__ import annotations

from dataclasses import dataclass

from PyQt5.QtWidgets import QWidget

from grabbergui.models.image.live_image import ImageModel
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.source_messages import CurrentMessages
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.bases import FileQuestions


@dataclass(frozen=True)
class SourceContext:
    """The sources that a window works on, and its means to ask and to report. One for each window."""

    open_sources: OpenSources
    image: ImageModel
    """The image of the current source."""
    messages: CurrentMessages
    preferences: Preferences
    files: FileQuestions
    window: QWidget
    """The parent of controllers and of dialogs; to a controller, it is any widget."""
