"""Starts the camera server: `ros2 launch grabbergui camera.launch.py source:=gige:`."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

INSTALLED = Path(__file__).absolute().parents[3] / "lib" / "grabbergui" / "grabbergui"
"""The program in the package that this file was installed with."""
PROGRAM = str(INSTALLED) if INSTALLED.is_file() else "grabbergui"
ARGUMENTS = {
    "source": ("sim:", "which camera; `grabbergui list` shows those that can be seen"),
    "name": ("/camera", "node, and what its topics begin with"),
    "frame_id": ("camera_optical_frame", "of the images' headers"),
    "calibration": ("", "camera_info's file; empty: the place below ROS_HOME"),
    "qos": ("reliable", "of the images: reliable, or sensor_data (best effort)"),
    "parameters": ("", "a parameter file: features to set, qualities of service; camera.yaml is one"),
    "program": (
        PROGRAM,
        "where it is not on PATH: .venv/bin/grabbergui",
    ),
}


def generate_launch_description() -> LaunchDescription:
    """One process: the camera, its topics, services and parameters."""
    declared = [
        DeclareLaunchArgument(name, default_value=value, description=meaning)
        for name, (value, meaning) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_server)])


def _server(context: LaunchContext) -> list[Node]:
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    options = {
        "--ros2": given["name"],
        "--frame-id": given["frame_id"],
        "--calibration": given["calibration"],
        "--qos": given["qos"],
    }
    server = Node(
        executable=given["program"],
        arguments=["serve", given["source"], *(word for option in options.items() for word in option)],
        parameters=[given["parameters"]] if given["parameters"] else [],
        output="screen",
    )
    return [server]
