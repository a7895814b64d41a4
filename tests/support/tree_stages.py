"""Feature trees on scripted grabbers."""

import pytest

from tree_bench import Stage


@pytest.fixture
def stage():
    """Make stages of features, on a scripted grabber of the given kind."""
    stages = []

    def build(*features, **how):
        stages.append(Stage(*features, **how))
        return stages[-1]

    yield build
    for stage in stages:
        stage.grabber.gate.set()
        stage.model.close()
        assert stage.worker.close()
