"""How TIAGo's head and arm are driven: chosen from what its controller manager lists. No I/O.

A stock TIAGo runs `joint_trajectory_controller/JointTrajectoryController` for each part. Another one may run
position controllers, or MoveIt Servo on top of the arm's controller. Names are those of PAL's public
configurations (`tiago_controller_configuration`), Humble and Jazzy.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

ACTIVE = "active"
TRAJECTORY_TYPES = ("joint_trajectory_controller/JointTrajectoryController",)
POSITION_TYPES = (
    "position_controllers/JointGroupPositionController",
    "forward_command_controller/ForwardCommandController",
)
SERVO_NODE = "/servo_node"
"MoveIt Servo's node in PAL's and MoveIt's launch files."
TWISTS = f"{SERVO_NODE}/delta_twist_cmds"


class Kind(Enum):
    """The messages that a part of the robot obeys."""

    TRAJECTORY = "trajectory"
    POSITION = "position"
    TWIST = "twist"


_PHRASE = {
    Kind.TRAJECTORY: "streamed trajectories",
    Kind.POSITION: "positions",
    Kind.TWIST: "twists",
}


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
        """Joints of which it claims an interface."""
        return frozenset(name.split("/")[-2] for name in self.claimed if "/" in name)


@dataclass(frozen=True)
class Drive:
    """Where commands for one part go."""

    kind: Kind
    topic: str
    controller: str = ""
    "Its name in the controller manager; empty if it is not known or not listed there."

    def __str__(self) -> str:
        return f"{_PHRASE[self.kind]} to {self.topic}"


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

    `listed` is None where no controller manager answered; then whoever listens to the stock names is
    believed. `listeners` counts the subscriptions of each topic. With `twists`, a topic for the hand's twist,
    MoveIt Servo is preferred wherever it runs: whoever started it wants its limits and collision checks.
    """
    if twists and listeners.get(twists):
        return Choice(Drive(Kind.TWIST, twists))
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
            return Choice(Drive(Kind.POSITION, f"/{controller.name}/commands", controller.name))
    return Choice(None, _why_none(part, concerned, listed))


def stock_topics(parts: Iterable[str]) -> list[str]:
    """The topics that are believed where no controller manager answers."""
    return [drive.topic for part in parts for drive in _stock_drives(part)]


def _choose_by_listeners(part: str, listeners: Mapping[str, int]) -> Choice:
    drives = _stock_drives(part)
    for drive in drives:
        if listeners.get(drive.topic):
            return Choice(drive)
    return Choice(None, f"nobody listens to {' or '.join(drive.topic for drive in drives)}")


def _stock_drives(part: str) -> list[Drive]:
    position = f"{part}_position_controller"
    return [
        _trajectories(f"{part}_controller"),
        Drive(Kind.POSITION, f"/{position}/commands", position),
    ]


def _trajectories(controller: str) -> Drive:
    return Drive(Kind.TRAJECTORY, f"/{controller}/joint_trajectory", controller)


def _positions(controller: Controller) -> bool:
    return all(interface.endswith("/position") for interface in controller.claimed)


def _why_none(part: str, concerned: Sequence[Controller], listed: Sequence[Controller]) -> str:
    # An inactive controller claims nothing, so it is known by its name alone.
    concerned = concerned or [one for one in listed if one.name.startswith(part)]
    if not concerned:
        return f"no controller has the {part}'s joints"
    return ", ".join(f"{one.name} ({one.type}) is {one.state}" for one in concerned)
