"""The launch file of the whole demonstration: what it starts, and, where launch is there, that it does."""

import argparse
import os
import runpy
import signal
import subprocess
import sys
import types
from pathlib import Path

import pytest

from grabbergui.cli import CommandParser
from grabbergui.servo.cli import servo, simulate_robots
from patience import PROGRAM

LAUNCH_FILE = Path(__file__).parents[3] / "resources/servo/tiago-demo.launch.py"
RUN = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

source = PythonLaunchDescriptionSource(sys.argv[1])
arguments = [word.split(":=") for word in sys.argv[2:]]
service = LaunchService()
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(source, launch_arguments=arguments)])
)
sys.exit(service.run())
"""


class Noted:
    """Stands for anything of launch: keeps what it was made of."""

    def __init__(self, *given, **named):
        self.given, self.named = given, named


@pytest.fixture
def described(monkeypatch):
    """The description, its parts named as launch names them, whether launch is installed or not."""
    names = {
        "launch": ("LaunchDescription",),
        "launch.actions": ("DeclareLaunchArgument", "ExecuteProcess", "RegisterEventHandler", "Shutdown"),
        "launch.conditions": ("IfCondition",),
        "launch.event_handlers": ("OnProcessExit",),
        "launch.substitutions": ("LaunchConfiguration", "PythonExpression"),
    }
    for module, kinds in names.items():
        stand_in = types.ModuleType(module)
        for kind in kinds:
            setattr(stand_in, kind, type(kind, (Noted,), {}))
        monkeypatch.setitem(sys.modules, module, stand_in)
    return runpy.run_path(str(LAUNCH_FILE))["generate_launch_description"]().given[0]


def options(*arguments):
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True, parser_class=CommandParser)
    for family in (servo, simulate_robots):
        family.add_commands(commands)
    return parser.parse_args(arguments)


def of_kind(described, name):
    return [part for part in described if type(part).__name__ == name]


def test_what_it_starts_are_commands_that_we_have(described):
    declared = of_kind(described, "DeclareLaunchArgument")
    defaults = {argument.given[0]: argument.named["default_value"] for argument in declared}
    commands = []
    for process in of_kind(described, "ExecuteProcess"):
        program, command, *words = process.named["cmd"]
        assert program == "grabbergui"
        commands.append(command)
        if command != "serve":  # of another family
            words = [defaults[word.given[0]] if isinstance(word, Noted) else word for word in words]
            assert options(command, *words).run
    assert commands == ["simulate-tiago", "serve", "servo"]


def test_both_ends_get_the_same_topic(described):
    def arm_topic(process):
        words = process.named["cmd"]
        return words[words.index("--arm-topic") + 1].given

    simulation, _, servo = of_kind(described, "ExecuteProcess")
    assert arm_topic(simulation) == arm_topic(servo) == ("arm_topic",)


@pytest.mark.ros2
def test_launch_starts_it_and_all_ends_with_the_loop(domain, tmp_path):
    pytest.importorskip("launch", reason="launch has no wheel; a system ROS 2 has it")
    pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
    pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
    program = tmp_path / "grabbergui"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m grabbergui "$@"\n')
    program.chmod(0o755)
    launched = subprocess.Popen(
        [sys.executable, "-c", RUN, str(LAUNCH_FILE), "seconds:=4", f"report:={tmp_path / 'out'}"],
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        said, _ = launched.communicate(timeout=PROGRAM)
    finally:
        if launched.poll() is None:
            os.killpg(launched.pid, signal.SIGKILL)
            launched.communicate()
    assert (tmp_path / "out/report.json").exists(), said
    assert "centring: a target is seen" in said
    assert "sending signal 'SIGINT' to process[grabbergui-1]" in said
