"""An operator's day at the real window: on a screen with a window manager, by mouse, wheel and keyboard.

After every step what the window says is compared with what is: the registers of the cameras, read past the
window, and the files that the program has open. The steps build on each other, as they do in a day.
"""

from __future__ import annotations

import re
import shutil
import sys
from contextlib import ExitStack, closing
from dataclasses import dataclass, field

import pytest

from desktop import PROGRAMS, Camera, Operator, screen
from grabbergui import sources
from grabbergui.core.errors import SourceNotFoundError
from grabbergui.net.yarp.os.name_server import NameServer
from patience import PROGRAM, until

missing = [name for name in PROGRAMS if shutil.which(name) is None]
pytestmark = [
    pytest.mark.skipif(
        sys.platform != "linux", reason="the hands are X11's, and what is open is read from /proc"
    ),
    pytest.mark.skipif(
        bool(missing), reason=f"not installed: {', '.join(missing)} (scripts/system-packages tests)"
    ),
]

ENGLISH = {
    "Live": r"Live",
    "Stopped": r"Stopped",
    "Waiting": r"Waiting for trigger",
    "Lost": r"Lost for \d+ s",
    "rate": r"\d+ fps",
    "recording": "● Recording",
    "lost": "connection lost",
}
SPANISH = {
    "Live": r"En directo",
    "Stopped": r"Parada",
    "Waiting": r"Esperando disparo",
    "Lost": r"Perdida desde hace \d+ s",
    "rate": r"\d+ im/s",
    "recording": "● Grabando",
    "lost": "conexión perdida",
}
TONES = {"Live": {"good", "busy"}, "Stopped": {"idle"}, "Waiting": {"busy"}, "Lost": {"bad"}}
MICROSECONDS = {"µs": 1.0, "ms": 1e3, "s": 1e6}


LOST = r"reconnecting since|reconectando desde"
BACK = r"back after [\d.]+ s|de vuelta tras [\d,.]+ s"
SAVED = r"Saved \d+ settings to .*day\.yaml"
PASSING = (BACK, SAVED)
"Messages that go by themselves after some seconds: on a busy machine, before anybody looks."


DAY = [
    "open", "no full screen", "tuned by mouse", "tuned by wheel", "stepped by Right",
    "stepped by shift+Right",
    "stepped by ctrl+Right", "typed", "taken back", "waiting for a trigger", "triggered", "trigger off",
    "lost", "back", "cable pulled", "second camera", "first recorded", "switched", "both recorded",
    "lost behind the other", "lost at the front", "back at the front", "switched back", "recorded",
    "four panes", "one pane", "shared", "set from elsewhere", "shared no more",
    "settings saved", "settings loaded", "settings taken back", "little room", "stopped",
]  # fmt: skip
"The steps after which the window is compared with what is so."


@dataclass
class Day:
    """A window, the cameras that it has open, and which of them is in front."""

    operator: Operator
    words: dict[str, str]
    cameras: list[Camera] = field(default_factory=list)
    "In the order in which they were opened."
    front: Camera | None = None
    agreed: list[str] = field(default_factory=list)
    "The steps after which everything shown was true."
    heard: int = 0
    "Messages that had appeared by the last of these."

    def agrees(self, step: str, messages: tuple[str, ...] = ()) -> dict:
        """Wait until all that is said is so, these messages and no others included; keep an image of it.

        Those that go by themselves must have appeared since the step before.
        """
        last: list[str] = []

        def agreed() -> dict | None:
            said = self.operator.said()
            last[:] = self.untruths(said, messages)
            return None if last else said

        try:
            said = until(agreed, step)
        except AssertionError:
            self.operator.shot(f"{step} FAILED")
            raise AssertionError(f"{step}: {'; '.join(last)}") from None
        assert not self.operator.complaints(), f"after {step}"
        self.operator.shot(step)
        self.agreed.append(step)
        self.heard = len(said["heard"])
        return said

    def untruths(self, said: dict, messages: tuple[str, ...]) -> list[str]:
        """Return statements of the window that are false, and facts that it leaves out."""
        front = self.front
        assert front is not None
        wrong = []

        def hold(is_so: bool, what: str) -> None:
            if not is_so:
                wrong.append(what)

        def state_of(camera: Camera) -> str:
            if not camera.answers:
                return "Lost"
            return "Waiting" if camera.triggered else "Live" if camera.streams else "Stopped"

        state, recorded = state_of(front), self.operator.is_writing(front.serial)
        lost = state == "Lost"
        title = said["title"]
        hold(
            bool(re.fullmatch(self.words[state], said["state"])),
            f"{front.serial} is {state}, said is {said['state']}",
        )
        hold(said["tone"] in TONES[state], f"the tone of {state} is {said['tone']}")
        hold(front.serial in title, f"{front.serial} is in front, the title is {title}")
        hold(
            title.startswith(self.words["recording"]) is recorded,
            f"recorded: {recorded}, the title is {title}",
        )
        hold((self.words["lost"] in title) is lost, f"lost: {lost}, the title is {title}")
        hold(said["locked"] is lost, f"lost: {lost}, controls locked: {said['locked']}")
        hold(bool(said["age"]) is lost, f"lost: {lost}, the image's age: {said['age']!r}")
        hold(not said["note"], f"a note over the image: {said['note']}")
        hold(said["recording"] is recorded, f"recorded: {recorded}, the button: {said['recording']}")
        hold(
            said["record"] is (recorded or state in ("Live", "Waiting")),
            f"{state}, but Record can be pressed",
        )
        if not lost:
            shown, there = microseconds(self.operator.ask("number('ExposureTime')")), front.exposure
            hold(shown == pytest.approx(there, rel=0.006), f"the exposure is {there} µs, said are {shown} µs")
        self._compare_tiles(said["tiles"], state_of, hold)
        passing = () if lost else PASSING
        texts = [text for text in said["messages"] if not any(re.search(each, text) for each in passing)]
        lasting = [each for each in messages if each not in PASSING]
        expected = len(texts) == len(lasting) and all(map(re.search, lasting, texts))
        hold(expected, f"messages: {texts}, expected: {lasting}")
        recent = said["heard"][self.heard :]
        for each in set(messages) & set(PASSING):
            hold(any(re.search(each, text) for text in recent), f"heard: {recent}, expected: {each}")
        return wrong

    def _compare_tiles(self, tiles: list[dict], state_of, hold) -> None:
        several = self.cameras if len(self.cameras) > 1 else []
        hold(len(tiles) == len(several), f"{len(tiles)} tiles for {len(several)} cameras")
        for tile, camera in zip(tiles, several, strict=False):
            state = state_of(camera)
            text = self.words["rate"] if state == "Live" else self.words[state].lower()
            hold(camera.serial in tile["name"], f"the tile of {camera.serial} is called {tile['name']}")
            hold(
                bool(re.match(text, tile["state"])),
                f"{camera.serial} is {state}, its tile says {tile['state']}",
            )
            recorded = self.operator.is_writing(camera.serial)
            hold(
                tile["recording"] is recorded,
                f"{camera.serial} recorded: {recorded}, its tile: {tile['recording']}",
            )
            hold(
                tile["current"] is (camera is self.front), f"{camera.serial} at the front: {tile['current']}"
            )


def microseconds(text: str | None) -> float | None:
    """A time as a control shows it; None where none is shown yet."""
    if (quantity := re.fullmatch(r"([\d.,\s]+?)\s*(µs|ms|s)", text or "")) is None:
        return None
    number, unit = quantity.groups()
    return float(re.sub(r"\s", "", number).replace(",", ".")) * MICROSECONDS[unit]


@pytest.fixture
def cameras():
    """Two cameras with power-on values of their own, still switched off."""
    both = (
        Camera("127.21.0.1", "DAY1", width=640, height=480, fps=8),
        Camera("127.21.0.2", "DAY2", width=320, height=240, fps=8, exposure=4000),
    )
    try:
        yield both
    finally:
        for camera in both:
            camera.lose_power()


@pytest.fixture
def sit_down(tmp_path, gvcp_port):
    """Opens windows, each on a screen of its own, and closes what is left."""
    with ExitStack() as stack:

        def begin(words, width, height, *arguments, **environment):
            desktop = stack.enter_context(screen(width, height))
            operator = Operator({**desktop, **environment}, tmp_path, *arguments)
            stack.callback(operator.close)
            return Day(operator, words)

        yield begin


def open_by_address(day, camera, key="Return"):
    """Return replaces the current source, Ctrl+B opens another beside it."""
    operator = day.operator
    operator.keys("ctrl+l")
    operator.until("window.sources.addressEdit.hasFocus()")
    operator.type(camera.uri)
    operator.keys(key)
    day.cameras.append(camera)


def type_exposure(operator, text):
    operator.click("row('ExposureTime').editor.field", 0.2)
    operator.keys("ctrl+a")
    operator.type(text)
    operator.keys("Return")


def choose_file(operator, keys, path):
    """In the dialog that these keys open."""
    operator.keys(keys)
    operator.until("dialog()")
    operator.keys("ctrl+a")
    operator.type(str(path))
    operator.keys("Return")


SLIDER = "row('ExposureTime').editor.slider()"


def fill_the_screen(day):
    """The image alone, and back."""
    operator = day.operator
    operator.keys("F11")
    operator.until("window.isFullScreen() and not window.header.isVisible()")
    operator.until("window.image.height() == window.height()")
    operator.keys("Escape")
    operator.until("not window.isFullScreen() and window.header.isVisible()")
    day.agrees("no full screen")


def tune(day, first):
    """Tune: by mouse, wheel and keyboard, and back."""
    operator = day.operator
    before = first.exposure
    operator.drag(SLIDER, 0.5, 40)
    until(lambda: first.exposure > before, "a longer exposure by the mouse")
    day.agrees("tuned by mouse")
    operator.until(f"{SLIDER}.hasFocus()")
    before = first.exposure
    operator.wheel(SLIDER, -2)
    until(lambda: first.exposure < before, "a shorter exposure by the wheel")
    day.agrees("tuned by wheel")
    # An arrow key is 1 %, with Shift a tenth of that and with Ctrl ten times as much.
    for keys, microseconds in (("Right", 200), ("shift+Right", 20), ("ctrl+Right", 2000)):
        type_exposure(operator, "20 ms")
        until(lambda: first.exposure == 20000, "20 ms")
        operator.click("row('ExposureTime').editor.field", 0.2)
        operator.keys("shift+Tab")
        operator.until(f"{SLIDER}.hasFocus()")
        operator.keys(keys)
        until(lambda: first.exposure != 20000, f"a step by {keys}")
        day.agrees(f"stepped by {keys}")
        assert first.exposure == 20000 + microseconds, keys
    type_exposure(operator, "25 ms")
    until(lambda: first.exposure == 25000, "25 ms")
    day.agrees("typed")
    # Quick changes of one feature are one step; the menu says how far it goes back.
    until(lambda: undone(operator)[1] == 25000, "the typed value in the menu")
    before, _ = undone(operator)
    operator.keys("ctrl+z")
    until(lambda: first.exposure == before, "the exposure from before")
    day.agrees("taken back")
    operator.keys("ctrl+shift+z")
    until(lambda: first.exposure == 25000, "25 ms")


def undone(operator):
    """Return the values of the menu's *Undo*: before and after the change."""
    before, after = re.findall(r"[\d.]+", operator.ask("window.actionUndo.text()"))
    return float(before), float(after)


def trigger(day, first):
    """Trigger."""
    operator = day.operator
    operator.keys("ctrl+f")
    operator.until("window.features.filterEdit.hasFocus()")
    operator.type("TriggerMode")
    operator.click("window.features.rows.rows('TriggerMode')[0].editor")
    operator.until("QApplication.activePopupWidget() is not None")
    operator.keys("Down", "Return")
    until(lambda: first.triggered, "the trigger")
    operator.until("window.image.triggerBar.sendButton.isVisible()")
    day.agrees("waiting for a trigger")
    count = operator.ask("frames()")
    operator.click("window.image.triggerBar.sendButton")
    operator.until(f"frames() == {count + 1}")
    day.agrees("triggered")
    operator.click("window.image.triggerBar.offButton")
    day.agrees("trigger off")


def lose_and_return(day, first):
    """Lose, return: by power and by cable."""
    first.lose_power()
    day.agrees("lost", (LOST,))
    first.begin()
    until(lambda: first.exposure == 25000, "the exposure from before the loss", PROGRAM)
    day.agrees("back", (BACK,))
    first.pull_cable()
    day.agrees("cable pulled", (LOST,))
    first.plug_cable()


def record_two(day, first, second):
    """A second camera, both recorded, one lost behind the other."""
    operator = day.operator
    open_by_address(day, second, "ctrl+b")
    day.agrees("second camera")
    operator.keys("ctrl+r")
    until(lambda: operator.is_writing(first.serial), "a recording")
    day.agrees("first recorded")
    operator.keys("F10")
    day.front = second
    day.agrees("switched")
    operator.click("window.recordingBar.recordButton")
    until(lambda: operator.is_writing(second.serial), "a recording")
    day.agrees("both recorded")
    operator.click("window.gallery.tiles[0]")
    day.front = first
    second.lose_power()
    day.agrees("lost behind the other")
    operator.keys("F10")
    day.front = second
    day.agrees("lost at the front", (LOST,))
    second.begin()
    day.agrees("back at the front", (BACK,))
    operator.keys("ctrl+r")
    until(lambda: not operator.is_writing(second.serial), "the end of the recording")
    operator.keys("F10")
    day.front = first
    day.agrees("switched back")
    operator.keys("ctrl+r")
    until(lambda: not operator.is_writing(first.serial), "the end of the recording")
    day.agrees("recorded")


def show_panes(day):
    """Both cameras large, side by side, and one again: by the menu's keys."""
    operator = day.operator
    for count, beside in (("4", 1), ("1", 0)):
        for keys, opened in (("alt+v", "menuView"), ("s", "menuPanes")):
            operator.keys(keys)
            operator.until(f"window.{opened}.isVisible()")
        operator.keys(count)
        operator.until("QApplication.activePopupWidget() is None")
        operator.until(f"len(window.image.paneArea.panes) == {beside}")
        day.agrees("four panes" if beside else "one pane")


def opens(remote):
    """Whether a source opens; its server may not have all its ports yet."""
    try:
        remote.open()
    except SourceNotFoundError:
        return False
    return True


def share(day, first):
    """Share the camera on YARP, by a name server of our own, with a program that sets it; then stop."""
    operator = day.operator
    dialog = "program.source_controls.sharer.dialog"
    box = f"{dialog}.yarpBox"
    with NameServer("127.0.0.1", 0) as server:
        address = f"{server.contact.host}:{server.contact.port}"
        operator.keys("alt+c")
        operator.until("window.menuCamera.isVisible()")
        operator.keys("r")
        operator.until(f"{dialog} is not None and {dialog}.isActiveWindow()")
        operator.click(f"{box}.serverEdit")
        operator.until(f"{box}.serverEdit.hasFocus()")
        operator.keys("ctrl+a")
        operator.type(address)
        operator.click(f"{box}.shareButton")
        operator.until(f"bool({box}.stateLabel.text()) and not {box}.nameEdit.isEnabled()")
        name = operator.ask(f"{box}.nameEdit.text()")
        day.agrees("shared")
        with closing(sources.create(f"yarp:{name}?nameserver={address}")) as remote:
            until(lambda: opens(remote), "the camera's ports")
            with closing(remote.open_queue(1)) as queue:
                remote.start()
                assert queue.get(PROGRAM).width == 640
            remote.write_feature("ExposureTime", 30000.0)
            until(lambda: first.exposure == 30000, "the exposure of the other program")
            operator.until(f"{dialog}.changesList.count() >= 1")
            day.agrees("set from elsewhere")
        operator.until(f"{dialog}.readersTree.topLevelItemCount() == 0")
        operator.click(f"{box}.shareButton")
        operator.until(f"{box}.nameEdit.isEnabled()")
        operator.keys("Escape")
        operator.until("dialog() is None")
        day.agrees("shared no more")
    type_exposure(operator, "25 ms")
    until(lambda: first.exposure == 25000, "25 ms")


def save_and_load(day, first, folder):
    """Save settings, load them, and take that back."""
    operator = day.operator
    settings = folder / "day.yaml"
    choose_file(operator, "ctrl+shift+s", settings)
    until(settings.exists, "the file")
    assert "ExposureTime: 25000" in settings.read_text()
    day.agrees("settings saved", (SAVED,))
    type_exposure(operator, "40 ms")
    until(lambda: first.exposure == 40000, "40 ms")
    choose_file(operator, "ctrl+shift+o", settings)
    until(lambda: first.exposure == 25000, "the exposure of the file")
    operator.until("'day' in (dialog() or '')")
    day.agrees("settings loaded")
    operator.keys("Escape")
    operator.until("dialog() is None")
    operator.keys("ctrl+z")
    until(lambda: first.exposure == 40000, "the exposure from before")
    day.agrees("settings taken back")


def make_little_room(day):
    """Little room."""
    operator = day.operator
    operator.resize(800, 600)
    operator.until("(window.width(), window.height()) == (800, 600)")
    day.agrees("little room")
    assert operator.ask("cut_off()") == []


def go_home(day, first, second):
    """Stop, and go home."""
    operator = day.operator
    operator.keys("F7")
    until(lambda: not first.streams, "the end of the stream")
    day.agrees("stopped")
    operator.keys("ctrl+q")
    until(lambda: operator.process.poll() is not None, "the end of the program", PROGRAM)
    assert not operator.complaints()
    for camera in (first, second):
        assert not camera.streams, "what was opened was closed"


def test_an_operators_day(sit_down, cameras, tmp_path):
    first, second = cameras
    first.begin()
    second.begin()
    day = sit_down(ENGLISH, 1280, 800)

    open_by_address(day, first)
    day.front = first
    day.agrees("open")
    fill_the_screen(day)
    tune(day, first)
    trigger(day, first)
    lose_and_return(day, first)
    record_two(day, first, second)
    show_panes(day)
    share(day, first)
    save_and_load(day, first, tmp_path)
    make_little_room(day)
    go_home(day, first, second)
    assert day.agreed == DAY


def test_in_spanish_on_a_small_screen_of_twice_as_many_pixels(sit_down, cameras):
    first, _ = cameras
    first.begin()
    day = sit_down(SPANISH, 1600, 1200, "--language", "es", "--theme", "dark", QT_SCALE_FACTOR="2")
    operator = day.operator
    assert operator.ask("window.devicePixelRatioF()") == 2
    operator.resize(1600, 1100)
    operator.until("(window.width(), window.height()) == (800, 550)")

    open_by_address(day, first)
    day.front = first
    day.agrees("Spanish open")
    type_exposure(operator, "12,5 ms")
    until(lambda: first.exposure == 12500, "12,5 ms")
    day.agrees("Spanish typed")
    operator.keys("ctrl+r")
    until(lambda: operator.is_writing(first.serial), "a recording")
    day.agrees("Spanish recorded")
    first.pull_cable()
    day.agrees("Spanish cable pulled", (LOST,))
    first.plug_cable()
    day.agrees("Spanish back", (BACK,))
    operator.keys("ctrl+r")
    until(lambda: not operator.is_writing(first.serial), "the end of the recording")
    operator.keys("F7")
    until(lambda: not first.streams, "the end of the stream")
    day.agrees("Spanish stopped")
    assert operator.ask("cut_off()") == []
