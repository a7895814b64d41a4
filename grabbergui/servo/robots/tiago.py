"""TIAGo's kinematic model: head, arm, body and camera as its URDF has them, computed by Pinocchio.

The base is the link that the torso lifts: it carries head and arm, so its height does not matter. `UrdfChain`
and `UrdfBody` work with any robot's URDF.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import pose
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.servo.clearance import Body, Capsule, CapsuleBody
from grabbergui.servo.robots.robot import KinematicModel
from grabbergui.servo.robots.urdf_chain import (
    HOW_TO_GET_IT,
    UrdfBody,
    UrdfChain,
    first_frame,
    frame_pose,
    load_urdf,
)

log = logging.getLogger(__name__)

BASE = "torso_lift_link"
HEAD = "head_2_link"
HEAD_JOINTS = ("head_1_joint", "head_2_joint")
HEAD_SIGNS = np.array([1.0, -1.0])
"TIAGo's tilt is positive upwards, the loop's downwards."
ARM_JOINTS = tuple(f"arm_{number}_joint" for number in range(1, 8))
HAND = "hand_grasping_frame"
CAMERA = "xtion_rgb_optical_frame"
HANDS = (HAND, "gripper_grasping_frame", "arm_tool_link")
"Tool frames of a Hey5 hand, of PAL's gripper, and of an arm without either; their x points outwards."
CAMERAS = ("head_front_camera_color_optical_frame", "head_front_camera_rgb_optical_frame", CAMERA)
"Optical frames of the camera in the head, on today's robots and on older ones."

HAND_AXES = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
"The loop's hand axes in TIAGo's hand frame, whose x points out of the palm: z forward, x down at home."


def shipped_urdf() -> Path:
    """TIAGo with a Hey5 hand, of example-robot-data. Raises SourceUnavailableError where that is missing."""
    try:
        from example_robot_data.robots_loader import getModelPath
    except ImportError as error:
        raise SourceUnavailableError(f"{HOW_TO_GET_IT} ({error})") from error
    file = "/tiago_description/robots/tiago.urdf"
    return Path(getModelPath(file) + file)


def model(urdf: Path | None = None, hand: str = "", camera: str = "", *, seen_in: str = "") -> KinematicModel:
    """TIAGo by a URDF, the shipped one by default; `hand` and `camera` are frames in it.

    By default they are the first of `HANDS` and `CAMERAS` that the URDF has; before those, `seen_in` is the
    frame that the camera itself names. Raises SourceUnavailableError without Pinocchio, a robot, or a frame.
    """
    path = urdf or shipped_urdf()
    model = load_urdf(path)
    hand, camera = hand or first_frame(model, HANDS), camera or first_frame(model, (seen_in, *CAMERAS))
    arm = UrdfChain("TIAGo's arm", model, BASE, ARM_JOINTS, hand, turned=HAND_AXES)
    return KinematicModel(
        "TIAGo",
        UrdfChain("TIAGo's head", model, BASE, HEAD_JOINTS, HEAD, signs=HEAD_SIGNS),
        arm,
        camera=frame_pose(model, HEAD, camera),
        home=np.radians([13.0, -13.0, -149.0, 118.0, -29.0, -68.0, 24.0]),
        # The torso lifted by 0.35 m on a floor at −0.95 m.
        stands=pose(translation=(-0.10, -0.15, 0.29)),
        body=_body(path, model, arm),
    )


def _body(path: Path, model: Any, arm: UrdfChain) -> Body:
    """Return the URDF's collision geometry if its meshes are on this computer, else rough capsules."""
    # From the base to the first joint, then joint to joint, the hand last.
    radii = (0.08, 0.08, 0.08, 0.07, 0.07, 0.06, 0.06, 0.07, 0.07)
    fixed = (
        Capsule("the torso", np.array([-0.06, 0.0, -0.6]), np.array([-0.06, 0.0, 0.0]), 0.15),
        Capsule("the head", np.array([0.10, 0.0, 0.15]), np.array([0.12, 0.0, 0.25]), 0.13),
    )
    links = CapsuleBody(arm, radii, fixed, guarded_from=4)
    try:
        return UrdfBody(path, model, arm, attached=ARM_JOINTS[:2], links=links)
    except SourceUnavailableError as error:
        log.warning("%s; rough capsules replace them", error)
        return links
