"""Payload bytes to arrays and images, and quantities computed from them."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core import compiled_loops, pfnc, pixel_loops, pixels, unpacking
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, SampleLayout
from grabbergui.core.pixels import Region, millimetres, polarisation
from images import (
    bayer_colour,
    dtype_of,
    each_format,
    eight_bit,
    encoded,
    expected_rgb,
    frame_of,
    random_values,
)
from pixel_formats import CONVERTIBLE

SIZES = [(16, 6), (12, 5), (4, 7), (8, 3)]
PACKED = [f for f in CONVERTIBLE if f.packed]
WHOLE = [f for f in CONVERTIBLE if f.layout is SampleLayout.WHOLE and not f.expands_chroma]
DEEP = [f for f in CONVERTIBLE if (f.layout is SampleLayout.WHOLE and f.depth > 8) or f.fields]
PLAIN = [f for f in CONVERTIBLE if not f.needs_range]
"Formats whose values have a white of their own."
EXACT = [f for f in PLAIN if f.family is not Family.SPARSE]
"Formats whose colours do not depend on how we interpolate."


@pytest.fixture(params=["compiled", "numpy"], autouse=True)
def loops(request):
    """Everything holds with numba's loops and without them."""
    if request.param == "compiled":
        pytest.importorskip("numba", reason="the extra `fast` is not installed")
        assert compiled_loops.wait()
    compiled_loops.disable(request.param == "numpy")
    yield
    compiled_loops.disable(False)


@each_format(CONVERTIBLE)
def test_raw_has_the_sensors_values(pixel_format):
    for width, height in SIZES:
        values = random_values(pixel_format, width, height)
        raw = frame_of(values, pixel_format).raw()
        assert raw.dtype == dtype_of(pixel_format.name)
        assert np.array_equal(raw, values), f"{width}×{height}"
        assert not raw.flags.writeable


@given(
    pixel_format=st.sampled_from(CONVERTIBLE),
    width=st.integers(1, 33),
    height=st.integers(1, 9),
    padding=st.integers(0, 9),
    big_endian=st.booleans(),
    seed=st.integers(0, 999),
    data=st.data(),
)
def test_any_lines_of_any_image(pixel_format, width, height, padding, big_endian, seed, data):
    values = random_values(pixel_format, width, height, seed)
    across = 4 if "411_" in pixel_format.name else 1
    assume(width % across == 0)  # how a group that is cut off ends is ours to choose
    frame = frame_of(values, pixel_format, padding_x=padding, big_endian=big_endian)
    first = data.draw(st.integers(0, height - 1))
    last = data.draw(st.integers(first + 1, height))
    assert np.array_equal(unpacking.lines(frame, first, last), values[first:last])


@pytest.mark.parametrize("padding", [1, 2, 5])
@each_format(CONVERTIBLE)
def test_padding_at_the_end_of_lines_is_no_image(pixel_format, padding):
    width = 12 if "411_" in pixel_format.name else 13
    values = random_values(pixel_format, width, 6)
    frame = frame_of(values, pixel_format, padding_x=padding)
    assert np.array_equal(frame.raw(), values)
    assert pixels.value_at(frame, 11, 4) == reference_value(values, pixel_format, 11, 4)


@each_format(PACKED)
def test_images_larger_than_a_block_of_words(pixel_format, monkeypatch):
    monkeypatch.setattr(pixel_loops, "_BLOCK", 3)
    values = random_values(pixel_format, 13, 7)
    assert np.array_equal(frame_of(values, pixel_format).raw(), values)


@each_format(DEEP)
def test_big_endian_pixels_are_swapped_to_native_order(pixel_format):
    values = random_values(pixel_format, 9, 4)
    frame = frame_of(values, pixel_format, big_endian=True)
    assert np.array_equal(frame.raw(), values)
    assert frame.raw().dtype.isnative
    assert pixels.value_at(frame, 8, 3) == reference_value(values, pixel_format, 8, 3)


@each_format(EXACT)
def test_rgb_is_the_reference_image(pixel_format):
    values = random_values(pixel_format, 16, 10)
    rgb = frame_of(values, pixel_format).rgb()
    expected = expected_rgb(values, pixel_format)
    assert rgb.shape == (10, 16, 3) and rgb.dtype == np.uint8
    inside = np.s_[1:-1, 1:-1] if pixel_format.family is Family.BAYER else np.s_[:]
    # Interpolating and multiplying round; taking and reordering components must not.
    tolerance = {Family.BAYER: 1, Family.YUV: 1.01}.get(pixel_format.family, 0)
    assert np.abs(rgb[inside] - expected[inside]).max() <= tolerance


@each_format(EXACT)
def test_mono_is_the_luma_of_rgb(pixel_format):
    values = random_values(pixel_format, 16, 10)
    mono = frame_of(values, pixel_format).mono()
    assert mono.shape == (10, 16) and mono.dtype == np.uint8
    if pixel_format.family is Family.YUV:
        luma = eight_bit(values, pixel_format.name)[..., pixel_format.raw_order.index("Y")]
        if pixel_format.standard:
            luma = np.clip((luma - 16) * 255 / 219, 0, 255)
        assert np.abs(mono - luma).max() <= 0.5
        return
    luma = expected_rgb(values, pixel_format) @ (0.299, 0.587, 0.114)
    inside = np.s_[1:-1, 1:-1] if pixel_format.family is Family.BAYER else np.s_[:]
    assert np.abs(mono[inside] - luma[inside]).max() <= 1.5


@pytest.mark.parametrize("colour", "RGB")
@each_format([f for f in CONVERTIBLE if f.family is Family.BAYER])
def test_a_red_scene_seen_through_the_mosaic_is_red(pixel_format, colour):
    """The proof of each Bayer order: only the pixels under filters of one colour see light."""
    light = (1 << pixel_format.depth) - 1
    mosaic = np.array(
        [[light * (bayer_colour(pixel_format.order, x, y) == colour) for x in range(8)] for y in range(8)]
    )
    frame = frame_of(mosaic, pixel_format)
    expected = [255 * (component == colour) for component in "RGB"]
    assert (frame.rgb() == expected).all()
    assert (pixels.for_display(frame, size=(4, 4)).pixels == expected).all()


@every_case(("width", "height"), [(1, 1), (2, 1), (1, 4), (2, 2), (5, 2)])
def test_a_bayer_image_too_small_to_interpolate_is_not_black(width, height):
    values = np.full((height, width), 200)
    rgb = frame_of(values, pfnc.by_name("BayerRG8")).rgb()
    assert rgb.shape == (height, width, 3)
    assert rgb.max() == 200


@each_format([f for f in CONVERTIBLE if f.subsampling == "422" and f.components == 2])
def test_the_last_pixel_of_an_odd_line_borrows_chroma(pixel_format):
    values = random_values(pixel_format, 7, 3)
    rgb = frame_of(values, pixel_format).rgb()
    luma, chroma = pixel_format.order.index("Y"), 1 - pixel_format.order.index("Y")
    completed = np.concatenate((values, values[:, -1:]), axis=1)
    completed[:, 7, chroma] = values[:, 5, chroma]
    expected = expected_rgb(completed, pixel_format)[:, :7]
    assert np.abs(rgb - expected).max() <= 1.01
    assert frame_of(values[:, :1], pixel_format).rgb().shape == (3, 1, 3)
    assert luma + chroma == 1


@each_format(WHOLE)
def test_the_payload_passes_through_without_a_copy(pixel_format):
    frame = frame_of(random_values(pixel_format, 8, 6), pixel_format)
    assert np.shares_memory(frame.raw(), frame.payload)


def test_eight_bit_images_pass_through_without_a_copy():
    mono = frame_of(random_values(pfnc.by_name("Mono8"), 8, 6), pfnc.by_name("Mono8"))
    assert np.shares_memory(mono.mono(), mono.payload)
    assert np.shares_memory(pixels.for_display(mono).pixels, mono.payload)
    rgb = frame_of(random_values(pfnc.by_name("RGB8"), 8, 6), pfnc.by_name("RGB8"))
    assert np.shares_memory(rgb.rgb(), rgb.payload)


def test_conversions_are_computed_once():
    frame = frame_of(random_values(pfnc.by_name("BayerRG12p"), 8, 6), pfnc.by_name("BayerRG12p"))
    assert np.shares_memory(frame.rgb(), frame.rgb())
    assert np.shares_memory(frame.raw(), frame.raw())


def test_deep_pixels_at_an_odd_address_are_read():
    values = random_values(pfnc.by_name("Mono12"), 8, 6)
    payload = np.frombuffer(b"?" + encoded(values, pfnc.by_name("Mono12")), np.uint8)[1:]
    frame = Frame(payload, 8, 6, pfnc.by_name("Mono12"))
    assert np.array_equal(frame.raw(), values)
    assert np.array_equal(frame.mono(), values >> 4)


def test_values_beyond_the_depth_are_white_not_dark():
    frame = Frame(np.frombuffer(b"\x00\x04\xff\xff\xff\x03", np.uint8), 3, 1, pfnc.by_name("Mono10"))
    assert frame.raw().tolist() == [[0x400, 0xFFFF, 0x3FF]]
    assert frame.mono().tolist() == [[255, 255, 255]]


@pytest.mark.parametrize("depth_name", ["Mono10", "Mono12", "Mono14", "Mono16"])
def test_every_deep_value_keeps_its_eight_highest_bits(depth_name):
    pixel_format = pfnc.by_name(depth_name)
    values = np.arange(1 << pixel_format.depth).reshape(-1, 256)
    frame = Frame(values.astype("<u2").view(np.uint8).reshape(-1), 256, len(values), pixel_format)
    assert np.array_equal(frame.mono(), values >> pixel_format.depth - 8)


@each_format(CONVERTIBLE)
def test_chunks_after_the_image_are_ignored(pixel_format):
    values = random_values(pixel_format, 8, 5)
    payload = np.frombuffer(encoded(values, pixel_format) + b"\xff" * 40, np.uint8)
    assert np.array_equal(Frame(payload, 8, 5, pixel_format).raw(), values)


@pytest.mark.parametrize("padding", [0, 3])
@each_format(CONVERTIBLE)
def test_one_missing_byte_is_an_error_that_names_the_sizes(pixel_format, padding):
    frame = frame_of(random_values(pixel_format, 8, 5), pixel_format, padding_x=padding)
    needed = frame.payload.size - padding  # the last line's padding may be missing
    frame.payload = frame.payload[: needed - 1]
    for use in (frame.raw, frame.rgb, frame.mono, lambda: pixels.for_display(frame)):
        with pytest.raises(PixelFormatError, match=f"{needed} bytes, the payload has {needed - 1}"):
            use()


@pytest.mark.parametrize("code", [0x81090001, 0x820C0001, pfnc.by_name("RGB10V1Packed").code])
def test_a_format_without_an_image_names_itself(code):
    frame = Frame(np.zeros(1000, np.uint8), 4, 4, pfnc.by_code(code))
    for use in (frame.raw, frame.rgb, frame.mono, lambda: pixels.value_at(frame, 0, 0)):
        with pytest.raises(PixelFormatError, match=f"0x{code:08X}.*raw bytes can still be saved"):
            use()


def reference_value(values, pixel_format, x, y):
    if pixel_format.family is Family.RGB:
        return tuple(
            int(values[y, x, pixel_format.order.index(c)]) for c in "RGBa" if c in pixel_format.order
        )
    pixel = values[y, x]
    if pixel.ndim == 0:
        return (pixel,)
    if pixel_format.family is not Family.YUV:
        return tuple(pixel)
    if pixel.size == 3:
        return tuple(pixel[list((1, 0, 2) if pixel_format.name.endswith(("_CbYCr", "_UYV")) else (0, 1, 2))])
    luma, first = pixel_format.order.index("Y"), x - x % 2
    second = first + 1 if first + 1 < values.shape[1] else first
    return values[y, x, luma], values[y, first, 1 - luma], values[y, second, 1 - luma]


@each_format(CONVERTIBLE)
def test_the_value_under_the_cursor(pixel_format):
    width = 8 if "411_" in pixel_format.name else 7
    values = random_values(pixel_format, width, 5)
    frame = frame_of(values, pixel_format)
    for y in range(5):
        for x in range(width):
            assert pixels.value_at(frame, x, y) == reference_value(values, pixel_format, x, y)


@pytest.mark.parametrize(("x", "y"), [(-1, 0), (0, -1), (7, 0), (0, 5)])
def test_no_value_outside_the_image(x, y):
    with pytest.raises(IndexError, match="7×5"):
        pixels.value_at(frame_of(np.zeros((5, 7), int), pfnc.by_name("Mono8")), x, y)


@pytest.mark.parametrize("name", ["Coord3D_C32f", "Coord3D_AC32f", "Coord3D_ABC32f"])
def test_nan_and_infinite_values_are_black(name):
    pixel_format = pfnc.by_name(name)
    payload = np.tile(np.array([0x7F800001, 0x7FC00000, 0x7F800000, 0x3F800000], np.uint32), 6).view(np.uint8)
    frame = Frame(payload, 8 // pixel_format.components, 3, pixel_format)
    mono = frame.mono()
    numbers = np.isfinite(frame.raw().reshape(*mono.shape, -1)[..., -1])
    assert np.array_equal(mono > 0, numbers) and numbers.any() and not numbers.all()
    assert np.array_equal(frame.rgb()[..., 0], mono)
    assert pixels.for_display(frame).pixels.shape[:2] == mono.shape


@given(
    pixel_format=st.sampled_from(CONVERTIBLE),
    width=st.integers(-1, 40),
    height=st.integers(-1, 12),
    size=st.integers(0, 3000),
    padding=st.integers(-1, 9),
    big_endian=st.booleans(),
)
def test_any_frame_gives_an_image_or_a_pixel_format_error(
    pixel_format, width, height, size, padding, big_endian
):
    payload = np.arange(size, dtype=np.uint64).astype(np.uint8)
    frame = Frame(payload, width, height, pixel_format, padding_x=padding, big_endian=big_endian)
    try:
        raw = frame.raw()
    except PixelFormatError:
        return
    assert raw.shape[:2] == frame.mono().shape == (height, width)
    assert frame.rgb().shape == (height, width, 3)
    assert pixels.for_display(frame, None, (5, 5)).pixels.shape[0] <= 5


def test_a_huge_image_with_a_tiny_payload_allocates_no_memory():
    frame = Frame(np.zeros(10, np.uint8), 2**31, 2**31, pfnc.by_name("Mono12p"))
    with pytest.raises(PixelFormatError):
        frame.rgb()


FLAT = {"W": 200, "R": 180, "G": 60, "B": 20}


@pytest.mark.parametrize("name", ["SCF1WBWG8", "SCF1WGWB8", "SCF1WGWR12p", "SCF1WRWG16"])
def test_a_flat_scene_behind_the_sparse_filter_has_its_colour(name):
    """The proof of each order: pixels see one of four levels of light, by the colour of their filter."""
    pixel_format = pfnc.by_name(name)
    rows = ("WBWG", "BWGW", "WGWR", "GWRW")
    start = next((x, y) for y in (0, 2) for x in (0, 2) if (rows[y] * 2)[x : x + 4] == name[4:8])
    mosaic = np.array(
        [[FLAT[rows[(y + start[1]) % 4][(x + start[0]) % 4]] for x in range(24)] for y in range(20)]
    )
    frame = frame_of(mosaic << pixel_format.depth - 8, pixel_format)
    assert np.abs(frame.rgb()[4:-4, 4:-4].astype(int) - (FLAT["R"], FLAT["G"], FLAT["B"])).max() <= 1
    assert pixels.for_display(frame, Region(6, 6, 10, 8)).pixels.shape == (12, 12, 3)


@each_format([f for f in CONVERTIBLE if f.needs_range])
def test_values_without_a_white_are_scaled_to_the_range_of_the_frame(pixel_format):
    values = random_values(pixel_format, 16, 10)
    shown = frame_of(values, pixel_format).mono()
    distance = (values if values.ndim == 2 else values[..., -1]).astype(float)
    expected = 1 + (distance - distance.min()) * 254 / (distance.max() - distance.min())
    assert np.abs(shown - expected).max() <= 1
    assert (frame_of(values, pixel_format).rgb() == shown[..., None]).all()


def test_unmeasured_pixels_are_black():
    pixel_format = pfnc.by_name("Coord3D_C32f")
    values = np.array([[np.nan, 100.0, 200.0, np.inf]], np.float32)
    assert frame_of(values, pixel_format).mono().tolist() == [[0, 1, 255, 0]]
    nothing = frame_of(np.full((2, 2), np.nan, np.float32), pixel_format)
    assert not nothing.mono().any()


def test_coordinates_become_millimetres_and_unmeasured_ones_nan():
    raw = np.array([[0, 10], [20, 65535]], np.uint16)
    found = millimetres(raw, 0.5, 100.0, invalid=0)
    assert found.dtype == np.float32 and np.isnan(found[0, 0])
    assert found[raw != 0].tolist() == [105.0, 110.0, 32867.5]


@every_case("angle", [0.0, 30.0, 45.0, 90.0, 120.0, 179.0])
@every_case("degree", [0.2, 1.0])
def test_malus_law_gives_degree_and_angle_back(angle, degree):
    """Behind a polariser at p light of an angle and degree has I / 2 × (1 + degree × cos 2(p - angle))."""
    filters = np.array([[90.0, 45.0], [135.0, 0.0]])
    cell = 1000 * (1 + degree * np.cos(np.radians(2 * (filters - angle))))
    found = polarisation(np.pad(np.tile(cell, (3, 4)), ((0, 1), (0, 0))))
    assert found.intensity.shape == (3, 4)
    assert np.allclose(found.intensity, 1000)
    assert np.allclose(found.degree, degree, atol=1e-4)
    assert np.allclose(found.angle, angle, atol=0.01) or np.allclose(found.angle, angle + 180, atol=0.01)


def test_darkness_is_not_polarised():
    assert not polarisation(np.zeros((4, 4), np.uint16)).degree.any()


@pytest.mark.parametrize(("width", "padding"), [(6, 0), (6, 3), (5, 1), (1, 0)])
def test_pixels_of_a_group_that_is_cut_off_have_the_chroma_before_or_none(width, padding):
    """Groups are U Y Y V Y Y. Without padding, they continue in the next line."""
    yuv, line = pfnc.by_name("YUV411_8_UYYVYY"), -(-width * 3 // 2)
    data = np.arange(2 * (line + padding) + 12, dtype=np.uint8)
    found = unpacking.lines(Frame(data, width, 2, yuv, padding_x=padding), 0, 2)
    for y in range(2):
        start, first = (y * (line + padding), 0) if padding else (0, y * width)
        end = start + line if padding else yuv.image_bytes(width, 2)
        for x in range(width):
            group, place = divmod(first + x, 4)
            at = start + 6 * group
            chroma = [each if each < end else each - 6 for each in (at, at + 3)]
            expected = [data[each] if each >= start else 128 for each in chroma]
            assert found[y, x, 1:].tolist() == expected
            assert found[y, x, 0] == data[min(at + (1, 2, 4, 5)[place], end - 1)]
