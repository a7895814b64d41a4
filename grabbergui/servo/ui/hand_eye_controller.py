"""Joins the window of hand–eye calibration to its model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PyQt5.QtCore import QObject

from grabbergui.core.errors import UsageError
from grabbergui.models.language import driver_text
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
from grabbergui.servo.hand_eye.run import EYES
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.models.hand_eye import HandEyeModel, Happened, Setup, Solution
from grabbergui.servo.models.hand_eye_text import plan_text
from grabbergui.servo.ui.hand_eye_view import HandEyePage, HandEyeView
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import FileQuestions

ENDING_S = 10.0
"""Seconds that a computation in progress may take to end after the dialog is closed."""


class HandEyeController(QObject):
    """Leads through the hand–eye calibration; the robot rests until the user lets it move.

    Make it on the GUI thread; `parent` is its window.
    It ends with the view's `closing`: the robot stops, and `model.close` waits for the threads.
    """

    def __init__(
        self, view: HandEyeView, stand: HandEyeStand, files: FileQuestions, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.model = HandEyeModel(stand)
        self._view, self._stand, self._files = view, stand, files
        self._valid = True
        self._bridge = Bridge(self)
        self._bridge.bind(self.model.ready, self._on_model_ready)
        self._bridge.bind(self.model.happened, self._on_model_happened)
        self._bridge.bind(self.model.solved, self._on_model_solved)
        self._bridge.bind(self.model.ended, self._on_model_ended)
        self._bridge.bind(self.model.saved, self._on_model_saved)
        self._bridge.bind(self.model.published, view.setPublished)
        self._bridge.bind(self.model.failed, view.showError)
        self._show_robot()
        view.setSetup(self.model.setup)
        view.setPublished(stand.published)
        view.setupChanged.connect(self._on_view_setup_changed)
        view.nextRequested.connect(self._on_view_next_requested)
        view.backRequested.connect(self._on_view_back_requested)
        view.stopPressed.connect(self.model.stop)
        view.useToggled.connect(self._on_view_use_toggled)
        view.publishToggled.connect(self._on_view_publish_toggled)
        view.viewChanged.connect(self.model.set_viewport)
        view.closing.connect(self.close)
        self.model.open()

    def close(self) -> None:
        """Stop the robot if it moves; the threads end by themselves. May be called twice."""
        self._bridge.close()
        self.model.close()

    def save_to(self, path: Path) -> None:
        """Save the robot's file."""
        placement = self._placement()
        if placement is not None:
            self.model.save(path, placement)

    def _on_view_setup_changed(self, setup: Setup) -> None:
        try:
            self.model.choose(setup)
        except UsageError as error:
            self._valid = False
            self._view.dismissAll()
            self._view.showError(driver_text(error))
        else:
            if not self._valid:
                self._view.dismissAll()
            self._valid = True

    def _on_view_next_requested(self) -> None:
        page = self._view.page
        if page is HandEyePage.SETUP:
            if why_not := self.model.why_not():
                self._view.showError(why_not)
            elif self._valid:
                self._show_plan()
        elif page is HandEyePage.PLAN:
            self._view.dismissAll()
            self._view.setPage(HandEyePage.MOTION)
            self._view.setRunning(True)
            self.model.start()
        elif page is HandEyePage.MOTION:
            self._view.setRunning(True)
            self.model.compute()
        else:
            self._ask_save()

    def _show_robot(self) -> None:
        refused = {eye: driver_text(self._stand.why_not(eye)) for eye in EYES}
        self._view.setRobot(self._stand.robot.name, refused)

    def _show_plan(self) -> None:
        model = self.model
        self._view.setPlan(plan_text(model.plan(), self._stand.robot.name, nominal=model.nominal))
        self._view.setPage(HandEyePage.PLAN)

    def _on_view_back_requested(self) -> None:
        if self._view.page is HandEyePage.PLAN:
            self._show_robot()
            self._view.setPage(HandEyePage.SETUP)
        elif not self.model.running:
            self._show_plan()

    def _on_view_use_toggled(self, on: bool) -> None:
        self.model.use(on)
        self._view.setInUse(self.model.in_use)

    def _on_view_publish_toggled(self, on: bool) -> None:
        placement = self._placement()
        if placement is None:
            self._view.setPublished(self._stand.published)
        else:
            self.model.publish(on, placement)

    def _placement(self) -> CameraMount | None:
        """Return the frames as they are named in the view; None, with a message, if a name is missing."""
        solution = self.model.solution
        mount, frame = self._view.frames
        if solution is None:
            return None
        if not mount or not frame:
            self._view.showError(
                self.tr("name both frames: what the camera is mounted on, and the camera's own")
            )
            return None
        return replace(solution.placement, mount=mount, frame=frame)

    def _ask_save(self) -> None:
        name = self._stand.file or Path.home() / f"{_file_name(self._stand.robot.name)}.hand-eye.yaml"
        path = self._files.to_save(self.tr("Save the robot's file"), str(name), "YAML (*.yaml)")
        if path is not None:
            self.save_to(path)

    def _on_model_ready(self) -> None:
        preview = self.model.take()
        if preview is not None:
            self._view.setPreview(preview)

    def _on_model_happened(self, event: Happened) -> None:
        if self._view.page is HandEyePage.MOTION:
            self._view.addEvent(event)

    def _on_model_ended(self, text: str, enough: bool) -> None:
        self._view.setEnded(text, enough=enough)

    def _on_model_solved(self, solution: Solution) -> None:
        unusable = ""
        if solution.setup.eye != "head":
            unusable = self.tr("Servoing uses a camera on the head; save this result or publish it")
        self._view.setPage(HandEyePage.RESULT)
        self._view.setSolution(solution, unusable)

    def _on_model_saved(self, path: Path) -> None:
        self._view.showNotice(
            self.tr("Saved as {0}. Use it with `grabbergui servo … --hand-eye {0}`").format(path)
        )


def _file_name(robot: str) -> str:
    return "-".join(robot.lower().split())
