"""A TIAGo as PAL's public configurations have it: controllers, their manager, and perhaps MoveIt Servo.

Names, joints and types are those of `tiago_controller_configuration` (Humble): `arm_controller`,
`head_controller`, `torso_controller`, `joint_state_broadcaster`, `mobile_base_controller`.
"""

from std_srvs.srv import SetBool

from grabbergui.net.ros2.requirements import load_type_support
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots.robot import ARM, HEAD
from grabbergui.servo.robots.tiago_topics import TiagoTopics

TRAJECTORIES = "joint_trajectory_controller/JointTrajectoryController"
JOINTS = {HEAD: tiago.HEAD_JOINTS, ARM: tiago.ARM_JOINTS}


class FakeTiago(TiagoTopics):
    """The simulated TIAGo with a controller manager; `servo` adds a MoveIt Servo node as of Jazzy."""

    def __init__(self, robot, *, servo=False):
        super().__init__(robot, stock=not servo)
        self.robot = robot
        self.manager_answers = True
        self.command_type, self.paused = 0, True
        self._servo = servo
        import controller_manager_msgs
        from controller_manager_msgs.srv import ListControllers

        load_type_support(controller_manager_msgs)
        node = self._ros.node
        node.create_service(ListControllers, "/controller_manager/list_controllers", self._list)
        if servo:
            import moveit_msgs
            from moveit_msgs.srv import ServoCommandType

            load_type_support(moveit_msgs)
            node.create_service(ServoCommandType, "/servo_node/switch_command_type", self._switch)
            node.create_service(SetBool, "/servo_node/pause_servo", self._pause)

    def _list(self, request, answer):
        from controller_manager_msgs.msg import ControllerState

        for part in (HEAD, ARM):
            controller = self.controllers.get(part)
            active = controller is None or controller.active
            interfaces = [f"{joint}/position" for joint in JOINTS[part]]
            answer.controller.append(
                ControllerState(
                    name=f"{part}_controller",
                    type=TRAJECTORIES,
                    state="active" if active else "inactive",
                    claimed_interfaces=interfaces if active else [],
                    required_command_interfaces=interfaces,
                )
            )
        for name, kind, claimed in (
            ("torso_controller", TRAJECTORIES, ["torso_lift_joint/position"]),
            ("joint_state_broadcaster", "joint_state_broadcaster/JointStateBroadcaster", []),
            (
                "mobile_base_controller",
                "diff_drive_controller/DiffDriveController",
                ["wheel_left_joint/velocity", "wheel_right_joint/velocity"],
            ),
        ):
            answer.controller.append(
                ControllerState(name=name, type=kind, state="active", claimed_interfaces=claimed)
            )
        return answer

    def _switch(self, request, answer):
        self.command_type = request.command_type
        answer.success = True
        return answer

    def _pause(self, request, answer):
        self.paused = request.data
        answer.success = True
        return answer

    def _on_twist(self, message):
        if self.command_type == 1 and not self.paused:
            super()._on_twist(message)
