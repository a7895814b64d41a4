"""The whole GenICam tree of a grabber by verbs, for any network that carries text both ways.

=====================  ==============================================  =====================================
request                result                                          errors
=====================  ==============================================  =====================================
hello                  version, device info, access
tree                   categories with the features' descriptions
feature SETTING…       the features as they are now, in order          FeatureNotFoundError
write SETTING VALUE    the feature as it is after                      any FeatureError
set SETTING VALUE      all that the write changed                      any FeatureError
execute SETTING        null                                            any FeatureError
changes REVISION       revision, and the names changed since           (names null: anything may have)
terminal LINE          what the terminal prints                        any
=====================  ==============================================  =====================================

A SETTING is a feature's name, from version 2 on also with its selectors: `Gain[GainSelector=Red]` is
selected, used and selected back in one step.
"""

from __future__ import annotations

from collections.abc import Callable

from grabbergui.core.errors import UsageError
from grabbergui.core.features import Feature
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey
from grabbergui.net.change_log import ChangeLog

VERSION = 2
"From 2 on selectors can stand with a name, and `set` is known."
_ANY = -1

Terminal = Callable[[str], str]
"""Runs a line typed from afar and gives what to print; raises GrabberError. Any thread."""


def no_terminal(line: str) -> str:
    """The terminal of a server that was given none."""
    raise UsageError(f"'{line}' was not run: no terminal is offered here")


class TreeService:
    """Answers verbs about one grabber. Any thread; each call may take as long as the camera."""

    def __init__(self, grabber: FrameGrabber, terminal: Terminal = no_terminal) -> None:
        self._grabber = grabber
        self._changes = ChangeLog(grabber)
        self._verbs: dict[str, tuple[int, Callable[..., object]]] = {
            "hello": (0, self._hello),
            "tree": (0, grabber.feature_tree),
            "feature": (_ANY, self._features),
            "write": (2, lambda name, value: grabber.write_setting(SettingKey.parse(name), value).feature),
            "set": (2, lambda name, value: grabber.write_setting(SettingKey.parse(name), value)),
            "execute": (1, lambda name: grabber.execute_setting(SettingKey.parse(name))),
            "changes": (1, self._changes_since),
            "terminal": (1, terminal),
        }
        # Verb: how many arguments, and what it does.

    def perform(self, verb: str, *arguments: str) -> object:
        """Carry out a verb; the result is for `feature_json.dumps`. Raises GrabberError."""
        if verb not in self._verbs:
            known = ", ".join(self._verbs)
            raise UsageError(f"'{verb}' is no verb, use one of {known}")
        count, action = self._verbs[verb]
        if count not in (_ANY, len(arguments)):
            raise UsageError(f"{verb} takes {count} arguments, not {len(arguments)}")
        return action(*arguments)

    def close(self) -> None:
        """Let go of the grabber. May be called twice."""
        self._changes.close()

    def _hello(self) -> dict[str, object]:
        return {"version": VERSION, "info": self._grabber.info, "access": self._grabber.access}

    def _features(self, *names: str) -> list[Feature]:
        # Once each at most: a request of 64 KiB could name one feature ten thousand times.
        if len(names) != len(set(names)):
            raise UsageError("feature: a name is given twice, name each feature once")
        return [self._grabber.read_setting(SettingKey.parse(name)) for name in names]

    def _changes_since(self, revision: str) -> dict[str, object]:
        if not revision.isdecimal():
            raise UsageError(f"revision '{revision}' is no number")
        number, names = self._changes.since(int(revision))
        return {"revision": number, "names": names}
