"""A connection to scripted sources, and all that it reports."""

import threading

from fakes import ScriptedGrabber
from grabbergui.models.open_source import LinkState
from grabbergui.models.source_opener import SourceOpener
from patience import PATIENCE, until

S = LinkState


class Source(ScriptedGrabber):
    """Opens as the test says; counts its calls and the threads they come from."""

    def __init__(self):
        super().__init__()
        self.calls = []
        self.opening = threading.Event()
        self.opening.set()
        self.problem = None
        self.start_problem = None

    def _note(self, call):
        self.calls.append(call)
        self.threads.add(threading.current_thread().name)

    def open(self, *args):
        self._note("open")
        assert self.opening.wait(PATIENCE)
        if self.problem:
            raise self.problem

    def start(self, *, keep_trigger=False):
        self._note("start")
        if self.start_problem:
            raise self.start_problem
        super().start()

    def stop(self):
        self._note("stop")
        super().stop()

    def close(self):
        self._note("close")
        super().close()


class Bench:
    def __init__(self):
        self.source = Source()
        self.others = {}
        self.link = SourceOpener(lambda uri: self.others.get(str(uri), self.source))
        self.sources = self.link.open_sources
        self.states = []
        self.failures = []
        self.sources.state_changed.connect(lambda state, reason: self.states.append(state))
        self.link.reports.failed.connect(self.failures.append)

    def texts(self):
        """The messages that are to be seen."""
        return [message.sentence for message in self.link.messages.shown(self.sources.current)]

    def until(self, state, seconds=PATIENCE):
        until(lambda: self.sources.state is state, f"{state}, with {self.failures},", seconds)

    def open_slowly_instead(self):
        """Return the current source, and the grabber that opens in its place once its `opening` is set."""
        self.others["sim:slow"] = slow = Source()
        slow.opening.clear()
        self.link.connect_to("sim:")
        self.until(S.STREAMING)
        first = self.sources.current
        self.link.connect_to("sim:slow")
        return first, slow
