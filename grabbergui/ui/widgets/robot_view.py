"""A robot in space: its skeleton, hand, camera, the marker and the workspace; drag to go round it.

Drawn by QPainter: some hundred lines need no OpenGL, and so it works on remote desktops and offscreen too.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PyQt5.QtCore import QLineF, QPointF, Qt
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF, QWheelEvent
from PyQt5.QtWidgets import QWidget

from grabbergui.calibration.geometry import Pose
from grabbergui.models.servoing import Posture
from grabbergui.servo.overlay import AXIS_COLOURS
from grabbergui.ui.widgets.orbit import NEAR, Orbit

RADIANS_PER_PIXEL = 0.008
TRAIL = 400
"Places of the hand that are remembered: some ten seconds."
TRAIL_STEP = 0.002
"Metres that it must move for another one."
_AXIS_M, _SIGHT_M, _FLOOR_M, _TILE_M, _ASIDE_M = 0.10, 0.22, -0.35, 0.25, 0.75
_EDGES = ((0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7))

Points = NDArray[np.float64]


class RobotView(QWidget):
    """Setters only. A drag rotates, the wheel goes nearer, a double click goes back."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(240, 200)
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        self.setToolTip(self.tr("Drag to turn, wheel to go nearer, double-click to go back"))
        self.orbit = Orbit()
        """From where it is looked at."""
        self._posture: Posture | None = None
        self._trail: deque[Points] = deque(maxlen=TRAIL)
        self._grip: QPointF | None = None

    @property
    def posture(self) -> Posture | None:
        """What is shown."""
        return self._posture

    def setPosture(self, posture: Posture | None) -> None:
        """Show where everything is; None: nothing is known."""
        self._posture = posture
        if posture is not None:
            hand = posture.hand[:3, 3]
            if not self._trail or float(np.linalg.norm(hand - self._trail[-1])) > TRAIL_STEP:
                self._trail.append(hand)
        self.update()

    # -- Qt's own --------------------------------------------------------------------------------
    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Take hold."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self._grip = event.localPos()
            self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Turn."""
        if event is not None and self._grip is not None:
            moved, self._grip = event.localPos() - self._grip, event.localPos()
            self.orbit = self.orbit.turned(moved.x() * RADIANS_PER_PIXEL, moved.y() * RADIANS_PER_PIXEL)
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Let go."""
        self._grip = None
        self.setCursor(Qt.CursorShape.OpenHandCursor)

    def mouseDoubleClickEvent(self, event: QMouseEvent | None) -> None:
        """Look as at first."""
        self.orbit = Orbit()
        self.update()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Go nearer or away."""
        if event is not None:
            self.orbit = self.orbit.nearer(1.0015 ** event.angleDelta().y())
            self.update()
            event.accept()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw everything, what is farther away first."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
        self._floor(painter)
        posture = self._posture
        if posture is None:
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            painter.drawText(
                self.rect(), Qt.AlignmentFlag.AlignCenter, self.tr("The robot has not answered yet")
            )
        else:
            self._surroundings(painter, posture)
            self._body(painter, posture)
            self._ends(painter, posture)
        painter.end()

    # -- parts -----------------------------------------------------------------------------------
    def _floor(self, painter: QPainter) -> None:
        tiles = np.arange(-2, 7) * _TILE_M
        low, high = tiles[0], tiles[-1]
        along = [((x, low - _ASIDE_M, _FLOOR_M), (x, high - _ASIDE_M, _FLOOR_M)) for x in tiles]
        across = [((low, y - _ASIDE_M, _FLOOR_M), (high, y - _ASIDE_M, _FLOOR_M)) for y in tiles]
        self._segments(painter, along + across, self._faint, 1.0)

    def _surroundings(self, painter: QPainter, posture: Posture) -> None:
        box = np.array(posture.workspace)
        corners = np.array(
            [(box[x, 0], box[y, 1], box[z, 2]) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        )
        self._segments(painter, corners[np.array(_EDGES)], self._faint, 1.0, Qt.PenStyle.DashLine)
        if len(self._trail) > 1:
            way = QColor(*AXIS_COLOURS[2])
            way.setAlpha(150)
            self._line(painter, np.array(self._trail), way, 1.5)

    def _body(self, painter: QPainter, posture: Posture) -> None:
        parts: list[tuple[float, Points, bool]] = []
        for line in posture.skeleton:
            flat, depths = self.orbit.line(line, self.width(), self.height())
            last = len(flat) - 1
            parts += [(float(depths[n]), part, n == last) for n, part in enumerate(flat)]
        steel = self._ink
        steel.setAlpha(235)
        painter.setBrush(self.palette().color(QPalette.ColorRole.Highlight))
        for depth, part, last in sorted(parts, key=lambda part: -part[0]):
            thick = self._pixels(0.030, depth)
            painter.setPen(QPen(steel, thick, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            painter.drawLine(QPointF(*part[0]), QPointF(*part[1]))
            painter.setPen(QPen(steel, 1.2))
            for end in part[: 1 if last else 2]:
                painter.drawEllipse(QPointF(*end), 0.75 * thick, 0.75 * thick)
        painter.setBrush(Qt.BrushStyle.NoBrush)

    def _ends(self, painter: QPainter, posture: Posture) -> None:
        self._triad(painter, np.eye(4), _AXIS_M, 1.0)
        if len(posture.sight):
            self._frustum(painter, posture.camera, posture.sight)
        if posture.person is not None:
            self._person(painter, posture.person)
        if posture.marker is not None:
            self._marker(painter, posture.marker, posture.marker_size)
        if posture.goal is not None:
            self._triad(painter, posture.goal, _AXIS_M, 1.0, Qt.PenStyle.DotLine)
        self._triad(painter, posture.hand, _AXIS_M, 2.5)

    def _frustum(self, painter: QPainter, camera: Pose, sight: Points) -> None:
        corners = (camera[:3, :3] @ (sight * _SIGHT_M).T).T + camera[:3, 3]
        colour = self.palette().color(QPalette.ColorRole.Highlight)
        glass = QColor(colour)
        glass.setAlpha(40)
        self._face(painter, corners, colour, glass)
        self._segments(painter, [(camera[:3, 3], corner) for corner in corners], colour, 1.2)

    def _marker(self, painter: QPainter, marker: Pose, size: float) -> None:
        for half, colour in ((0.8 * size, QColor("white")), (0.5 * size, QColor("black"))):
            corners = [(-half, half, 0, 1), (half, half, 0, 1), (half, -half, 0, 1), (-half, -half, 0, 1)]
            self._face(painter, (marker @ np.array(corners).T)[:3].T, self._ink, colour)
        self._triad(painter, marker, 0.06, 2.0)

    def _person(self, painter: QPainter, person: Points) -> None:
        seen = self.orbit.seen(person[None])
        if seen[0, 2] > NEAR:
            flat, radius = (
                self.orbit.flat(seen, self.width(), self.height())[0],
                self._pixels(0.1, seen[0, 2]),
            )
            painter.setPen(QPen(self._ink, 1.2, Qt.PenStyle.DotLine))
            painter.drawEllipse(QPointF(*flat), radius, 1.25 * radius)

    def _triad(
        self,
        painter: QPainter,
        pose: Pose,
        length: float,
        width: float,
        style: Qt.PenStyle = Qt.PenStyle.SolidLine,
    ) -> None:
        origin = pose[:3, 3]
        tips = origin + length * pose[:3, :3].T
        for axis in np.argsort(-self.orbit.seen(tips)[:, 2]):
            self._line(painter, [origin, tips[axis]], QColor(*AXIS_COLOURS[axis]), width, style)

    @property
    def _ink(self) -> QColor:
        return self.palette().color(QPalette.ColorRole.WindowText)

    @property
    def _faint(self) -> QColor:
        return self.palette().color(QPalette.ColorRole.Mid)

    # -- lines -----------------------------------------------------------------------------------
    def _line(
        self,
        painter: QPainter,
        points: ArrayLike,
        colour: QColor,
        width: float,
        style: Qt.PenStyle = Qt.PenStyle.SolidLine,
    ) -> None:
        array = np.asarray(points, np.float64)
        self._segments(painter, np.stack((array[:-1], array[1:]), axis=1), colour, width, style)

    def _segments(
        self,
        painter: QPainter,
        ends: ArrayLike,
        colour: QColor,
        width: float,
        style: Qt.PenStyle = Qt.PenStyle.SolidLine,
    ) -> None:
        painter.setPen(QPen(colour, width, style, Qt.PenCapStyle.RoundCap))
        flat, _ = self.orbit.segments(ends, self.width(), self.height())
        lines = [QLineF(*line) for line in flat.reshape(-1, 4).tolist()]
        if lines:
            painter.drawLines(*lines)

    def _face(self, painter: QPainter, corners: Points, line: QColor, fill: QColor) -> None:
        seen = self.orbit.seen(corners)
        if float(seen[:, 2].min()) <= NEAR:
            return
        painter.setPen(QPen(line, 1.2))
        painter.setBrush(fill)
        painter.drawPolygon(_polygon(self.orbit.flat(seen, self.width(), self.height())))
        painter.setBrush(Qt.BrushStyle.NoBrush)

    def _pixels(self, metres: float, depth: float) -> float:
        """How wide something is at a depth, at least a pixel."""
        reach = self.orbit.flat(
            np.array([(0.0, 0.0, depth), (metres, 0.0, depth)]), self.width(), self.height()
        )
        return max(1.0, math.hypot(*(reach[1] - reach[0])))


def _polygon(points: Iterable[Points]) -> QPolygonF:
    return QPolygonF([QPointF(float(x), float(y)) for x, y in points])
