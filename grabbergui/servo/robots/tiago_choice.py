"""The choice of the controller that moves each part of TIAGo, from the controller manager's list. No I/O.

A stock TIAGo runs `joint_trajectory_controller/JointTrajectoryController` for each part. Another one may run
position controllers, or MoveIt Servo on top of the arm's controller. Names are those of PAL's public
configurations (`tiago_controller_configuration`), Humble and Jazzy.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from grabbergui.servo.robots.tiago_messages import CommandKind, Drive

ACTIVE = "active"
TRAJECTORY_TYPES = ("joint_trajectory_controller/JointTrajectoryController",)
POSITION_TYPES = (
    "position_controllers/JointGroupPositionController",
    "forward_command_controller/ForwardCommandController",
)
SERVO_NODE = "/servo_node"
"MoveIt Servo's node in PAL's and MoveIt's launch files."
TWISTS = f"{SERVO_NODE}/delta_twist_cmds"


@dataclass(frozen=True)
class Controller:
    """One row of `/controller_manager/list_controllers`."""

    name: str
    type: str
    state: str
    claimed: tuple[str, ...] = ()
    "Command interfaces such as `arm_1_joint/position`, or `chained_controller/arm_1_joint/position`."

    @property
    def joints(self) -> frozenset[str]:
        """The joints whose interfaces it claims."""
        return frozenset(name.split("/")[-2] for name in self.claimed if "/" in name)


@dataclass(frozen=True)
class Choice:
    """How one part is driven, or why it is not."""

    drive: Drive | None
    reason: str = ""

    def __str__(self) -> str:
        return str(self.drive) if self.drive is not None else f"not driven: {self.reason}"


def choose(
    part: str,
    joints: Collection[str],
    listed: Sequence[Controller] | None,
    listeners: Mapping[str, int],
    twists: str = "",
) -> Choice:
    """Choose the drive of a part ("head" or "arm") with these joints.

    `listed` is None if no controller manager answered; then any subscriber of a stock topic counts as the
    controller. `listeners` counts the subscriptions of each topic. With `twists`, a topic for the hand's
    twist, MoveIt Servo is preferred if it runs, for its limits and collision checks.
    """
    if twists and listeners.get(twists):
        return Choice(Drive(CommandKind.TWIST, twists))
    if listed is None:
        return _choose_by_listeners(part, listeners)
    wanted = frozenset(joints)
    concerned = [controller for controller in listed if controller.joints & wanted]
    for controller in concerned:
        if controller.state != ACTIVE or controller.joints != wanted:
            continue
        if controller.type in TRAJECTORY_TYPES:
            return Choice(_trajectories(controller.name))
        if controller.type in POSITION_TYPES and _positions(controller):
            return Choice(Drive(CommandKind.POSITION, f"/{controller.name}/commands", controller.name))
    return Choice(None, _why_none(part, concerned, listed))


def stock_topics(parts: Iterable[str]) -> list[str]:
    """Return the topics that are tried if no controller manager answers."""
    return [drive.topic for part in parts for drive in _stock_drives(part)]


def _choose_by_listeners(part: str, listeners: Mapping[str, int]) -> Choice:
    drives = _stock_drives(part)
    for drive in drives:
        if listeners.get(drive.topic):
            return Choice(drive)
    return Choice(None, f"no controller subscribes to {' or '.join(drive.topic for drive in drives)}")


def _stock_drives(part: str) -> list[Drive]:
    position = f"{part}_position_controller"
    return [
        _trajectories(f"{part}_controller"),
        Drive(CommandKind.POSITION, f"/{position}/commands", position),
    ]


def _trajectories(controller: str) -> Drive:
    return Drive(CommandKind.TRAJECTORY, f"/{controller}/joint_trajectory", controller)


def _positions(controller: Controller) -> bool:
    return all(interface.endswith("/position") for interface in controller.claimed)


def _why_none(part: str, concerned: Sequence[Controller], listed: Sequence[Controller]) -> str:
    # An inactive controller claims nothing, so only its name identifies it.
    concerned = concerned or [one for one in listed if one.name.startswith(part)]
    if not concerned:
        return f"no controller has the {part}'s joints"
    return ", ".join(f"{one.name} ({one.type}) is {one.state}" for one in concerned)
