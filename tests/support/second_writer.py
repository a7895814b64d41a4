"""A second writer that keeps moving a camera's selector while a test writes through another path."""

import itertools
import sys
import threading
from contextlib import contextmanager

from grabbergui.core.settings import SettingKey
from patience import until

BALANCE = "BalanceRatioSelector"
OTHERS = {"Green": 1.25, "Blue": 1.75}
"""Ratios of the channels that a write of the red one must leave alone."""


def ratio(channel):
    return SettingKey("BalanceRatio", ((BALANCE, channel),))


@contextmanager
def selector_in_motion(camera, selector, entries, turns=20):
    """Move the selector until the end of the block, `turns` times at least.

    Threads take turns as often as Python lets them, so that each gap between two steps is met.
    """
    interval = sys.getswitchinterval()
    ended, moves = threading.Event(), itertools.count(1)
    moved = [0]

    def move():
        for entry in itertools.cycle(entries):
            if ended.is_set():
                return
            camera.write_feature(selector, entry)
            moved[0] = next(moves)

    thread = threading.Thread(target=move, name="second writer")
    sys.setswitchinterval(1e-6)
    thread.start()
    try:
        yield
        until(lambda: moved[0] >= turns or not thread.is_alive(), "the second writer")
    finally:
        ended.set()
        thread.join()
        sys.setswitchinterval(interval)
    assert moved[0] >= turns, "the second writer failed"


@contextmanager
def others_stay(camera):
    """Let a second writer select green and blue in turn; neither ratio has changed in the end."""
    for channel, value in OTHERS.items():
        camera.write_setting(ratio(channel), value)
    with selector_in_motion(camera, BALANCE, OTHERS):
        yield
    assert {channel: camera.read_setting(ratio(channel)).value for channel in OTHERS} == OTHERS
