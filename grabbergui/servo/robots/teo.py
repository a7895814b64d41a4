"""TEO's head and right arm with the trunk fixed, and where its camera sits.

The base lies in the trunk: x forward, y left, z up. Tables as teo-configuration-files has them
(fixedTrunk-head, fixedTrunk-rightArm); the head's limits are those of the older table.
"""

from __future__ import annotations

import math

import numpy as np

from grabbergui.calibration.geometry import Pose, pose, rotation_from_vector
from grabbergui.servo.collision import Capsule, CapsuleBody
from grabbergui.servo.robots.dh_chain import DhChain, Joint
from grabbergui.servo.robots.robot import KinematicModel

FASTEST = 50.0
"Degrees per second of every joint."

HEAD = DhChain(
    "TEO's head",
    pose(translation=(0.0, 0.0, 0.1932)),
    (
        Joint("AxialNeck", 0.0, 0.4675, 0.0, -90.0, -73.0, 73.0, FASTEST),
        Joint("FrontalNeck", 0.0, 0.0, 0.0, 90.0, -29.0, 8.4, FASTEST),
    ),
    pose(),
)

RIGHT_ARM = DhChain(
    "TEO's right arm",
    np.array([[0, 1, 0, 0], [0, 0, 1, -0.3469], [1, 0, 0, 0.4982], [0, 0, 0, 1]], np.float64),
    (
        Joint("FrontalRightShoulder", 0.0, 0.0, 0.0, -90.0, -98.1, 106.0, FASTEST),
        Joint("SagittalRightShoulder", -90.0, 0.0, 0.0, -90.0, -75.5, 22.4, FASTEST),
        Joint("AxialRightShoulder", -90.0, -0.32901, 0.0, -90.0, -80.1, 57.0, FASTEST),
        Joint("FrontalRightElbow", 0.0, 0.0, 0.0, 90.0, -99.6, 98.4, FASTEST),
        Joint("AxialRightWrist", 0.0, -0.215, 0.0, -90.0, -80.4, 99.6, FASTEST),
        Joint("FrontalRightWrist", -90.0, 0.0, -0.09, 0.0, -115.1, 44.7, FASTEST),
    ),
    np.array([[0, 0, -1, -0.0975], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], np.float64),
)

CAMERA_PITCH = 20.0
"Degrees by which the camera looks further down than the head."

CAMERA_ON_HEAD: Pose = pose(
    rotation_from_vector((0.0, math.radians(CAMERA_PITCH), 0.0)) @ [[0, 0, 1], [-1, 0, 0], [0, -1, 0]],
    (0.07, 0.0, 0.06),
)
"The camera's optical frame (z forward, x right, y down) as seen from the head's (x forward, z up)."

HOME = np.radians([-20.0, -5.0, 0.0, -80.0, 0.0, 20.0])
"The hand before the model, the elbow bent."

BODY = CapsuleBody(
    RIGHT_ARM,
    # From the shoulder's three joints, which share a place, along the upper arm, the forearm and the hand.
    radii=(0.06, 0.06, 0.06, 0.06, 0.05, 0.05, 0.05),
    fixed=(
        Capsule("the trunk", np.array([0.0, 0.0, -0.35]), np.array([0.0, 0.0, 0.42]), 0.16),
        Capsule("the head", np.array([0.0, 0.0, 0.62]), np.array([0.0, 0.0, 0.76]), 0.13),
    ),
    guarded_from=2,
)
"Rough shapes of our own around the links, as the tables have none; the other arm is taken to hang down."

MODEL = KinematicModel("TEO", HEAD, RIGHT_ARM, CAMERA_ON_HEAD, HOME, stands=pose(), body=BODY)
