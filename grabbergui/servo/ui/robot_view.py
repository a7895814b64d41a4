"""A robot, its camera's view and its goal, drawn in three dimensions."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PyQt5.QtCore import QLineF, QPointF, Qt
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF, QWheelEvent
from PyQt5.QtWidgets import QWidget

from grabbergui.calibration.geometry import Pose
from grabbergui.servo.models.servoing import Posture
from grabbergui.servo.overlay import AXIS_COLOURS
from grabbergui.ui.shown_text import set_tooltip

Points = NDArray[np.float64]

NEAR = 0.05
"Metres before the eye at which lines are cut off."
STEEPEST = math.radians(85)
NEAREST, FARTHEST = 0.4, 12.0
"Metres from the eye to the centre of its orbit."
FOCAL = 2.5
"Focal length of the eye, as a multiple of the view's shorter side."
RADIANS_PER_PIXEL = 0.008
TRAIL = 400
"Places of the hand in its trail: some ten seconds."
TRAIL_STEP = 0.002
"Metres that the hand must move for the next place."
_AXIS_M, _SIGHT_M, _FLOOR_M, _TILE_M, _ASIDE_M = 0.10, 0.22, -0.35, 0.25, 0.75
_EDGES = ((0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7))


@dataclass(frozen=True)
class Orbit:
    """An eye in a world whose z points up."""

    azimuth: float = math.radians(-38)
    "Radians about z from x, of the direction in which the eye is seen from the centre."
    elevation: float = math.radians(22)
    distance: float = 2.2
    "Metres."
    centre: tuple[float, float, float] = (0.3, -0.15, 0.28)

    def turned(self, right: float, down: float) -> Orbit:
        """Turn the view by so many radians, as a drag does: the scene follows the pointer."""
        elevation = min(max(self.elevation + down, -STEEPEST), STEEPEST)
        return replace(self, azimuth=self.azimuth - right, elevation=elevation)

    def nearer(self, factor: float) -> Orbit:
        """Move nearer by a factor, within limits."""
        return replace(self, distance=min(max(self.distance / factor, NEAREST), FARTHEST))

    @property
    def axes(self) -> Points:
        """(3, 3): rows are the eye's right, down and forward in the world."""
        ce, se = math.cos(self.elevation), math.sin(self.elevation)
        ca, sa = math.cos(self.azimuth), math.sin(self.azimuth)
        forward = -np.array([ce * ca, ce * sa, se])
        right = np.array([-sa, ca, 0.0])
        return np.array([right, np.cross(forward, right), forward])

    def seen(self, points: ArrayLike) -> Points:
        """(n, 3): points of the world as the eye has them, right, down and forward in metres."""
        axes = self.axes
        eye = np.array(self.centre) - self.distance * axes[2]
        turned: Points = (np.asarray(points, np.float64) - eye) @ axes.T
        return turned

    def flat(self, seen: Points, width: float, height: float) -> Points:
        """(n, 2): pixels of a view of that size. All must lie before the eye."""
        focal = FOCAL * min(width, height) / 2
        flat: Points = seen[:, :2] / seen[:, 2:] * focal + (width / 2, height / 2)
        return flat

    def segments(self, ends: ArrayLike, width: float, height: float) -> tuple[Points, Points]:
        """The parts of lines (n, 2, 3) that lie before the eye: (m, 2, 2) pixels, (m,) depths in metres."""
        seen = self.seen(np.asarray(ends, np.float64).reshape(-1, 3)).reshape(-1, 2, 3)
        seen = seen[seen[:, :, 2].max(axis=1) > NEAR]
        for this, other in ((0, 1), (1, 0)):
            behind = seen[:, this, 2] < NEAR
            start, end = seen[behind, this], seen[behind, other]
            part = (NEAR - start[:, 2]) / (end[:, 2] - start[:, 2])
            seen[behind, this] = start + (end - start) * part[:, None]
        flat = self.flat(seen.reshape(-1, 3), width, height).reshape(-1, 2, 2)
        return flat, seen[:, :, 2].mean(axis=1)

    def line(self, points: ArrayLike, width: float, height: float) -> tuple[Points, Points]:
        """The same of a line through points (n, 3)."""
        array = np.asarray(points, np.float64)
        return self.segments(np.stack((array[:-1], array[1:]), axis=1), width, height)


class RobotView(QWidget):
    """A drag rotates the view, the wheel moves nearer, a double click resets it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(240, 200)
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        set_tooltip(self, self.tr("Drag to rotate, wheel to zoom, double-click to reset"))
        self.orbit = Orbit()
        """The viewpoint."""
        self._posture: Posture | None = None
        self._trail: deque[Points] = deque(maxlen=TRAIL)
        self._grip: QPointF | None = None

    def setPosture(self, posture: Posture | None) -> None:
        """Show where everything is; None if nothing is known."""
        self._posture = posture
        if posture is not None:
            hand = posture.hand[:3, 3]
            if not self._trail or float(np.linalg.norm(hand - self._trail[-1])) > TRAIL_STEP:
                self._trail.append(hand)
        self.update()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Remember where the drag begins."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self._grip = event.localPos()
            self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Turn the view."""
        if event is not None and self._grip is not None:
            moved, self._grip = event.localPos() - self._grip, event.localPos()
            self.orbit = self.orbit.turned(moved.x() * RADIANS_PER_PIXEL, moved.y() * RADIANS_PER_PIXEL)
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """End the drag."""
        self._grip = None
        self.setCursor(Qt.CursorShape.OpenHandCursor)

    def mouseDoubleClickEvent(self, event: QMouseEvent | None) -> None:
        """Reset the view."""
        self.orbit = Orbit()
        self.update()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Move nearer or farther."""
        if event is not None:
            self.orbit = self.orbit.nearer(1.0015 ** event.angleDelta().y())
            self.update()
            event.accept()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw everything, farther parts first."""
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
            self._marker(painter, posture.marker, posture.marker_extent)
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

    def _marker(self, painter: QPainter, marker: Pose, extent: tuple[float, float]) -> None:
        x, y, margin = extent[0] / 2, extent[1] / 2, 0.3 * min(extent)
        for right, up, colour in ((x + margin, y + margin, QColor("white")), (x, y, QColor("black"))):
            corners = [(-right, up, 0, 1), (right, up, 0, 1), (right, -up, 0, 1), (-right, -up, 0, 1)]
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
        """Return the width of something at a depth, at least a pixel."""
        reach = self.orbit.flat(
            np.array([(0.0, 0.0, depth), (metres, 0.0, depth)]), self.width(), self.height()
        )
        return max(1.0, math.hypot(*(reach[1] - reach[0])))


def _polygon(points: Iterable[Points]) -> QPolygonF:
    return QPolygonF([QPointF(float(x), float(y)) for x, y in points])
