"""Starts the camera server: `ros2 launch camera.launch.py source:=gige:192.168.0.10`."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    """One process: the camera, its topics, services and parameters."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("source", default_value="sim:", description="which camera"),
            DeclareLaunchArgument("name", default_value="/camera", description="node and prefix of topics"),
            DeclareLaunchArgument("frame_id", default_value="camera_optical_frame"),
            DeclareLaunchArgument("calibration", default_value="camera_info.yaml"),
            ExecuteProcess(
                cmd=[
                    "grabbergui",
                    "serve",
                    LaunchConfiguration("source"),
                    "--ros2",
                    LaunchConfiguration("name"),
                    "--frame-id",
                    LaunchConfiguration("frame_id"),
                    "--calibration",
                    LaunchConfiguration("calibration"),
                ],
                output="screen",
            ),
        ]
    )
