"""TIAGo follows and reaches: `ros2 launch tiago-demo.launch.py`, simulated from camera to gripper.

With the robot: `… robot:=real source:=gige:192.168.0.10 calibration:=camera.yaml`.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, RegisterEventHandler, Shutdown
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration, PythonExpression


def generate_launch_description() -> LaunchDescription:
    """The robot or its simulation, its camera on `/camera`, and the servo loop; all end with the loop."""
    robot, source = LaunchConfiguration("robot"), LaunchConfiguration("source")
    arm_topic = LaunchConfiguration("arm_topic")
    servo = ExecuteProcess(
        cmd=[
            *("grabbergui", "servo", "--robot", "tiago", "--source", "ros2:/camera", "--headless"),
            *("--publish-ros2", "--arm-topic", arm_topic),
            *("--seconds", LaunchConfiguration("seconds"), "--report", LaunchConfiguration("report")),
        ],
        output="screen",
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("robot", default_value="simulated", choices=["simulated", "real"]),
            DeclareLaunchArgument("source", default_value="", description="the real robot's camera"),
            DeclareLaunchArgument("calibration", default_value="camera_info.yaml", description="of that"),
            DeclareLaunchArgument("arm_topic", default_value="/servo_node/delta_twist_cmds"),
            DeclareLaunchArgument("seconds", default_value="60"),
            DeclareLaunchArgument("report", default_value="out", description="folder of report and video"),
            ExecuteProcess(
                cmd=["grabbergui", "simulate-tiago", "--arm-topic", arm_topic],
                condition=IfCondition(PythonExpression(["'", robot, "' == 'simulated'"])),
                output="screen",
            ),
            ExecuteProcess(
                cmd=[
                    *("grabbergui", "serve", source, "--ros2", "/camera"),
                    *("--frame-id", "xtion_rgb_optical_frame"),
                    *("--calibration", LaunchConfiguration("calibration")),
                ],
                # Where a ROS driver serves the camera there is nothing to start.
                condition=IfCondition(PythonExpression(["'", robot, "' == 'real' and '", source, "' != ''"])),
                output="screen",
            ),
            servo,
            RegisterEventHandler(OnProcessExit(target_action=servo, on_exit=Shutdown())),
        ]
    )
