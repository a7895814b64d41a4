import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.core.errors import UsageError
from grabbergui.servo.robots import teo

CHAINS = [teo.HEAD, teo.RIGHT_ARM]


def some_angles(chain, count=10):
    random = np.random.default_rng(4)
    return random.uniform(chain.low, chain.high, (count, len(chain.joints)))


def test_teo_s_hand_at_rest_is_where_its_table_puts_it():
    """Upper arm, forearm and hand hang straight down: 0.32901 + 0.215 + 0.09 + 0.0975 below the shoulder."""
    hand = teo.RIGHT_ARM.forward(np.zeros(6))
    assert hand[:3, 3] == pytest.approx([0, -0.3469, 0.4982 - 0.32901 - 0.215 - 0.09 - 0.0975], abs=1e-9)
    assert hand[:3, 2] == pytest.approx([0, 0, -1], abs=1e-9)


def test_teo_s_head_looks_ahead_at_rest_turns_left_and_looks_down():
    assert teo.HEAD.forward([0, 0]) == pytest.approx(geometry.pose(translation=(0, 0, 0.1932 + 0.4675)))
    left = teo.HEAD.forward(np.radians([90 * 0.5, 0]))[:3, 0]
    assert left == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0])
    assert teo.HEAD.forward(np.radians([0, 8]))[2, 0] < 0


@pytest.mark.parametrize("chain", CHAINS, ids=lambda chain: chain.name)
def test_the_jacobian_is_the_derivative(chain):
    step = 1e-6
    for angles in some_angles(chain):
        jacobian = chain.jacobian(angles)
        for joint in range(len(chain.joints)):
            moved = angles.copy()
            moved[joint] += step
            numeric = geometry.diff(chain.forward(angles), chain.forward(moved), step)
            assert jacobian[:, joint] == pytest.approx(numeric, abs=1e-5)


def test_joint_velocities_give_the_twist_that_was_asked_for():
    arm, angles = teo.RIGHT_ARM, teo.HOME
    twist = np.array([0.03, -0.02, 0.05, 0.1, 0.05, -0.1])
    velocities = arm.velocities_for(angles, twist, damping=1e-6)
    assert arm.jacobian(angles) @ velocities == pytest.approx(twist, abs=1e-6)


def test_no_joint_is_ever_asked_to_be_too_fast_even_where_the_arm_is_straight():
    arm = teo.RIGHT_ARM
    for angles in (*some_angles(arm), np.zeros(6)):
        velocities = arm.velocities_for(angles, np.array([0.5, 0.5, 0.5, 2.0, 2.0, 2.0]))
        assert (np.abs(velocities) <= arm.fastest + 1e-9).all()


def test_a_joint_at_its_limit_is_not_driven_further():
    arm = teo.RIGHT_ARM
    for joint, (low, high) in enumerate(zip(arm.low, arm.high, strict=True)):
        for limit, sign in ((low, 1), (high, -1)):
            angles = teo.HOME.copy()
            angles[joint] = limit
            for axis in range(6):
                twist = np.zeros(6)
                twist[axis] = 0.1
                for direction in (twist, -twist):
                    assert arm.velocities_for(angles, direction)[joint] * sign >= -1e-12


def test_inverse_kinematics_finds_what_it_can_and_says_what_it_cannot():
    arm = teo.RIGHT_ARM
    goal = arm.forward(teo.HOME + 0.2)
    angles = arm.inverse(goal, teo.HOME)
    assert arm.forward(angles) == pytest.approx(goal, abs=1e-5)
    assert arm.inverse(geometry.pose(translation=(2.0, 0, 0)), teo.HOME) is None


@pytest.mark.parametrize("angles", [[0.0], [0.0, float("nan")], [0, 0, 0]])
def test_angles_that_are_none_are_refused(angles):
    with pytest.raises(UsageError, match="TEO's head has 2 joints"):
        teo.HEAD.forward(angles)
