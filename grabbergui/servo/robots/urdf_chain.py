"""Kinematics of any robot that comes as a URDF, computed by Pinocchio: chains of joints, and distances."""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from grabbergui.calibration.geometry import Pose, Vector, inverse, pose
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.servo.clearance import FREE, Body, Capsule, CapsuleBody, Clearance
from grabbergui.servo.kinematics import Chain

HOW_TO_GET_IT = "Pinocchio is not installed: run pip install 'grabbergui[servo]'"
"Advice for a computer without it."


def load_urdf(path: Path) -> Any:
    """Pinocchio's model of a file. Raises SourceUnavailableError without Pinocchio or without the file."""
    try:
        import pinocchio
    except ImportError as error:
        raise SourceUnavailableError(f"{HOW_TO_GET_IT} ({error})") from error
    try:
        return pinocchio.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise SourceUnavailableError(f"{path} is no robot that Pinocchio can read: {error}") from error


def frame_pose(model: Any, ancestor: str, frame: str) -> Pose:
    """A frame as seen from another, all joints at rest. Raises SourceUnavailableError where it is missing."""
    import pinocchio

    _require(model, (ancestor, frame))
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    first, second = (data.oMf[model.getFrameId(name)].homogeneous for name in (ancestor, frame))
    seen: Pose = inverse(first) @ second
    return seen


def first_frame(model: Any, names: Sequence[str]) -> str:
    """The first of these frames that the model has. Raises SourceUnavailableError where it has none."""
    found = next((name for name in names if name and model.existFrame(name)), "")
    if not found:
        raise SourceUnavailableError(
            f"the robot's URDF has none of the frames {', '.join(filter(None, names))}"
        )
    return found


def _require(model: Any, names: Sequence[str]) -> None:
    known = {frame.name for frame in model.frames}
    if missing := [name for name in names if name not in known]:
        raise SourceUnavailableError(f"the robot's URDF has no {' and no '.join(missing)}")


def package_folders(path: Path) -> list[str]:
    """Where `package://NAME/…` in a URDF may be: above the file, and in sourced ROS installations."""
    prefixes = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    return [*map(str, path.parents), *(f"{prefix}/share" for prefix in prefixes)]


class UrdfBody(Body):
    """The collision geometry of a URDF: the convex hulls of an arm's links against those of all the rest."""

    def __init__(
        self, path: Path, model: Any, chain: Chain, attached: Sequence[str], links: CapsuleBody
    ) -> None:
        """`attached` are the arm's joints whose links adjoin the body; `links` are its capsules, for boxes.

        Raises SourceUnavailableError where the file names shapes that are not on this computer.
        """
        import pinocchio

        self._pinocchio, self._model, self._links = pinocchio, model, links
        try:
            self._shapes = pinocchio.buildGeomFromUrdf(
                model, str(path), pinocchio.GeometryType.COLLISION, package_dirs=package_folders(path)
            )
        except (ValueError, RuntimeError) as error:
            raise SourceUnavailableError(f"{path}: its collision geometry cannot be read: {error}") from error
        # Distances between hulls take a hundredth of the time of those between meshes, and are never larger.
        for shape in self._shapes.geometryObjects:
            if hasattr(shape.geometry, "buildConvexHull"):
                shape.geometry.buildConvexHull(True, "Qt")
                shape.geometry = shape.geometry.convex
        self._pair(chain.joint_names, attached)
        self._places = [model.joints[model.getJointId(name)].idx_q for name in chain.joint_names]
        self._scratch = threading.local()

    def _pair(self, joints: Sequence[str], attached: Sequence[str]) -> None:
        first = self._model.getJointId(joints[0])
        moving, rest = [], []
        for index, shape in enumerate(self._shapes.geometryObjects):
            supports = list(self._model.supports[shape.parentJoint])
            if first not in supports:
                rest.append(index)
            elif self._model.names[shape.parentJoint] not in attached:
                moving.append(index)
        for arm in moving:
            for other in rest:
                self._shapes.addCollisionPair(self._pinocchio.CollisionPair(arm, other))

    def nearest(self, arm: Vector) -> Clearance:
        """By the hulls; all other joints are at rest, the torso at its lowest, where the base is nearest."""
        shapes = self._shapes
        if not len(shapes.collisionPairs):
            return FREE
        angles = self._pinocchio.neutral(self._model)
        angles[self._places] = arm
        data, distances = self._data()
        least = self._pinocchio.computeDistances(self._model, data, shapes, distances, angles)
        pair = shapes.collisionPairs[least]
        names = [shapes.geometryObjects[index].name.rpartition("_")[0] for index in (pair.first, pair.second)]
        return Clearance(float(distances.distanceResults[least].min_distance), *names)

    def _data(self) -> tuple[Any, Any]:
        """Pinocchio's workspaces, one pair for each thread: making them takes several times a check."""
        scratch = self._scratch
        if not hasattr(scratch, "data"):
            scratch.data = self._model.createData(), self._shapes.createData()
        made: tuple[Any, Any] = scratch.data
        return made

    def capsules(self, arm: Vector) -> list[Capsule]:
        """Return the capsules of `links`."""
        return self._links.capsules(arm)


class UrdfChain(Chain):
    """Some joints of a model between two of its frames, with all others at rest."""

    def __init__(
        self,
        name: str,
        model: Any,
        base: str,
        joints: Sequence[str],
        end: str,
        *,
        turned: ArrayLike | None = None,
        signs: ArrayLike | None = None,
    ) -> None:
        """`base` and `end` are frames of the model; the tool is the latter, `turned` by a rotation (3, 3).

        `signs` are −1 for joints that the model turns the other way, else 1. Raises SourceUnavailableError
        where a name is not in the model.
        """
        import pinocchio

        _require(model, (base, *joints, end))
        self._pinocchio = pinocchio
        resting = [model.getJointId(other) for other in model.names[1:] if other not in joints]
        self._model = pinocchio.buildReducedModel(model, resting, pinocchio.neutral(model))
        self._scratch = threading.local()
        self._signs = np.ones(len(joints)) if signs is None else np.asarray(signs, np.float64)
        low, high = (
            self._signs * limit for limit in (self._model.lowerPositionLimit, self._model.upperPositionLimit)
        )
        fastest = self._model.velocityLimit
        super().__init__(name, joints, np.minimum(low, high), np.maximum(low, high), fastest)
        self._from_world = frame_pose(self._model, base, "universe")
        self._end = self._model.getFrameId(end)
        self._tool = pose(turned)

    @override
    def frames(self, angles: ArrayLike) -> list[Pose]:
        """Return the frames; except for the first and the last, a frame's z is its joint's axis."""
        data, tool = self._placed(angles)
        links = [link.homogeneous for link in list(data.oMi)[1:]]
        return [np.eye(4), *(self._from_world @ link for link in links), tool]

    @override
    def forward(self, angles: ArrayLike) -> Pose:
        """Return the last of `frames`, in less than half of the time."""
        return self._placed(angles)[1]

    def _data(self) -> Any:
        """Pinocchio's workspace, one for each thread: making it takes as long as what is computed in it."""
        scratch = self._scratch
        if not hasattr(scratch, "data"):
            scratch.data = self._model.createData()
        return scratch.data

    def _placed(self, angles: ArrayLike) -> tuple[Any, Pose]:
        """Pinocchio's data with every joint in its place, until this thread's next call; and the tool."""
        data = self._data()
        self._pinocchio.forwardKinematics(self._model, data, self._signs * self.checked(angles))
        end = self._pinocchio.updateFramePlacement(self._model, data, self._end).homogeneous
        tool: Pose = self._from_world @ (end @ self._tool)
        return data, tool

    @override
    def jacobian(self, angles: ArrayLike) -> NDArray[np.float64]:
        jacobian = self._pinocchio.computeFrameJacobian(
            self._model,
            self._data(),
            self._signs * self.checked(angles),
            self._end,
            self._pinocchio.LOCAL_WORLD_ALIGNED,
        )
        axes = self._from_world[:3, :3]
        in_base: NDArray[np.float64] = np.vstack((axes @ jacobian[:3], axes @ jacobian[3:])) * self._signs
        return in_base
