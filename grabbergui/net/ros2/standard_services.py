"""The services that ROS camera drivers offer as `std_srvs`: the stream, a trigger, one push, and user sets.

Each is a `std_srvs/Trigger` below the node's name, without arguments, so `ros2 service call`, behaviour trees
and buttons of rqt and Foxglove need no interface of ours. A failure is a reply with the reason.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from grabbergui.core.errors import FeatureAccessError, GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import Role
from grabbergui.net.numbered_features import FeatureModes
from grabbergui.net.ros2.callers import create_service
from grabbergui.net.ros2.runtime import sendable

_TRIGGER = "TriggerSoftware"
_SET, _LOAD, _SAVE = "UserSetSelector", "UserSetLoad", "UserSetSave"
_FACTORY = ("Default", "Factory")
"""Beginnings of the names of user sets that no camera overwrites."""
_ONE_PUSH = {
    "exposure_once": Role.EXPOSURE,
    "gain_once": Role.GAIN,
    "white_balance_once": Role.BALANCE_RATIO,
}


class StandardServices:
    """Offers what the camera has at the start. Callbacks run on the node's thread."""

    def __init__(self, node: Any, grabber: FrameGrabber) -> None:
        from std_srvs.srv import Trigger

        self._grabber = grabber
        self._modes = FeatureModes(grabber)
        for name, action in self._actions():
            create_service(node, Trigger, f"~/{name}", partial(self._answer, action))

    def _actions(self) -> Iterator[tuple[str, Callable[[], None]]]:
        grabber = self._grabber
        yield "start", lambda: grabber.start(keep_trigger=True)
        yield "stop", grabber.stop
        if grabber.has_feature(_TRIGGER):
            yield "trigger", lambda: grabber.execute(_TRIGGER)
        for service, role in _ONE_PUSH.items():
            name = grabber.role(role)
            if name is not None and self._modes.has_one_push(name):
                yield service, partial(self._modes.regulate_once, name)
        yield from self._user_sets()

    def _user_sets(self) -> Iterator[tuple[str, Callable[[], None]]]:
        if not self._grabber.has_feature(_SET):
            return
        for entry in self._grabber.feature(_SET).entries:
            place = f"user_sets/{re.sub('[^A-Za-z0-9_]', '_', entry.name)}"
            for verb, command in (("load", _LOAD), ("save", _SAVE)):
                kept = command == _SAVE and entry.name.startswith(_FACTORY)
                if self._grabber.has_feature(command) and not kept:
                    key = SettingKey(command, ((_SET, entry.name),))
                    yield f"{place}/{verb}", partial(self._execute, key)

    def _execute(self, key: SettingKey) -> None:
        """Run a command, with the stream paused if the camera refuses it otherwise."""
        try:
            self._grabber.execute_setting(key)
        except FeatureAccessError:
            if not self._grabber.streaming:
                raise
            self._grabber.stop()
            try:
                self._grabber.execute_setting(key)
            finally:
                self._grabber.start(keep_trigger=True)

    @staticmethod
    def _answer(action: Callable[[], None], _request: Any, answer: Any) -> Any:
        try:
            action()
            answer.success = True
        except GrabberError as error:
            answer.success, answer.message = False, sendable(str(error))
        return answer
