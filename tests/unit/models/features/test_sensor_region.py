import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes import ScriptedGrabber
from grabbergui.core.errors import FeatureNotFoundError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.pixels import Region
from grabbergui.core.uri import SourceUri
from grabbergui.driver.sim.device import create
from grabbergui.models.features import sensor_region
from patience import PATIENCE


def axis(name, value, low, high, step):
    numbers = {"value": value, "minimum": low, "maximum": high, "increment": step}
    return Feature(name=name, kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, **numbers)


@pytest.fixture
def camera():
    camera = create(SourceUri.parse("sim:"))
    camera.open()
    yield camera
    camera.close()


def test_a_region_is_sent_and_the_whole_sensor_again(camera):
    full = sensor_region.apply_full(camera)
    assert (full.x, full.y) == (0, 0)
    width, height = full.width, full.height
    assert width == camera.feature("Width").maximum
    part = sensor_region.apply(camera, Region(501, 303, 600, 400))
    assert abs(part.x - 501) <= 16 and abs(part.y - 303) <= 16
    assert abs(part.width - 600) <= 16 and abs(part.height - 400) <= 16
    smaller = sensor_region.apply(camera, Region(100, 100, 200, 100))
    assert (smaller.x, smaller.y) == (
        pytest.approx(part.x + 100, abs=16),
        pytest.approx(part.y + 100, abs=16),
    )
    assert sensor_region.apply_full(camera) == Region(0, 0, width, height)


def test_the_stream_continues_with_the_region(camera):
    queue = camera.open_queue()
    camera.start()
    part = sensor_region.apply(camera, Region(64, 64, 128, 96))
    assert camera.streaming
    queue.clear()
    frame = queue.get(PATIENCE)
    assert (frame.width, frame.height) == (part.width, part.height)


def test_a_trigger_that_was_set_stays(camera):
    camera.start()
    camera.write_feature("TriggerMode", "On")
    sensor_region.apply(camera, Region(0, 0, 64, 64))
    assert camera.feature("TriggerMode").value == "On"


def test_a_camera_without_offsets_is_named():
    grabber = ScriptedGrabber([axis("Width", 10, 1, 10, 1), axis("Height", 10, 1, 10, 1)])
    assert not sensor_region.has_region(grabber)
    with pytest.raises(FeatureNotFoundError, match="OffsetX"):
        sensor_region.apply_full(grabber)


@given(
    start=st.integers(-50, 3000),
    length=st.integers(1, 3000),
    first=st.integers(0, 20),
    steps=st.tuples(st.sampled_from((1, 2, 4, 8, 16)), st.sampled_from((1, 2, 4, 8))),
    least=st.integers(1, 8),
    count=st.integers(0, 100),
)
def test_every_write_of_a_region_is_allowed(start, length, first, steps, least, count):
    size_step, offset_step = steps
    least *= size_step
    before = least + count * size_step
    first *= offset_step
    size = axis("Width", before, least, first + before, size_step)
    offset = axis("OffsetX", first, 0, first, offset_step)
    new_size, new_offset = sensor_region.fitted(start, length, size, offset)
    assert least <= new_size <= before and (new_size - least) % size_step == 0
    assert new_offset >= 0 and new_offset % offset_step == 0
    assert new_offset + new_size <= first + before, "never beyond what is sent now"
