import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pictures import bayer_colour, encoded, expected_rgb, frame_of, random_values

from grabbergui.core import pfnc, pixels, unpacking
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import CONVERTIBLE, Family, Layout

SIZES = [(16, 6), (13, 5), (6, 7), (3, 3)]
PACKED = [f for f in CONVERTIBLE if f.layout in (Layout.PACKED_LSB, Layout.PACKED_GIGE)]
WHOLE = [f for f in CONVERTIBLE if f not in PACKED]
DEEP = [f for f in WHOLE if f.depth > 8]


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_raw_is_what_the_sensor_sent(pixel_format, width, height):
    values = random_values(pixel_format, width, height)
    raw = frame_of(values, pixel_format).raw()
    assert raw.dtype == (np.uint8 if pixel_format.depth == 8 else np.uint16)
    assert np.array_equal(raw, values)
    assert not raw.flags.writeable


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
@pytest.mark.parametrize("padding", [1, 2, 5])
def test_padding_at_the_end_of_lines_is_no_picture(pixel_format, padding):
    values = random_values(pixel_format, 13, 6)
    frame = frame_of(values, pixel_format, padding_x=padding)
    assert np.array_equal(frame.raw(), values)
    assert pixels.value_at(frame, 12, 4) == reference_value(values, pixel_format, 12, 4)


@pytest.mark.parametrize("pixel_format", PACKED, ids=str)
def test_pictures_larger_than_a_block_of_words(pixel_format, monkeypatch):
    monkeypatch.setattr(unpacking, "_BLOCK", 3)
    values = random_values(pixel_format, 13, 7)
    assert np.array_equal(frame_of(values, pixel_format).raw(), values)


@pytest.mark.parametrize("pixel_format", DEEP, ids=str)
def test_big_endian_pixels(pixel_format):
    values = random_values(pixel_format, 9, 4)
    frame = frame_of(values, pixel_format, big_endian=True)
    assert np.array_equal(frame.raw(), values)
    assert frame.raw().dtype.isnative
    assert pixels.value_at(frame, 8, 3) == (values[3, 8],)


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
def test_rgb_is_the_reference_picture(pixel_format):
    values = random_values(pixel_format, 16, 10)
    rgb = frame_of(values, pixel_format).rgb()
    expected = expected_rgb(values, pixel_format)
    assert rgb.shape == (10, 16, 3) and rgb.dtype == np.uint8
    inside = np.s_[1:-1, 1:-1] if pixel_format.family is Family.BAYER else np.s_[:]
    # Interpolating and multiplying round; taking and reordering components must not.
    tolerance = {Family.BAYER: 1, Family.YUV: 1.01}.get(pixel_format.family, 0)
    assert np.abs(rgb[inside] - expected[inside]).max() <= tolerance


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
def test_mono_is_the_luma_of_rgb(pixel_format):
    values = random_values(pixel_format, 16, 10)
    mono = frame_of(values, pixel_format).mono()
    assert mono.shape == (10, 16) and mono.dtype == np.uint8
    if pixel_format.family is Family.YUV:
        assert np.array_equal(mono, values[..., pixel_format.order.index("Y")])
        return
    luma = expected_rgb(values, pixel_format) @ (0.299, 0.587, 0.114)
    inside = np.s_[1:-1, 1:-1] if pixel_format.family is Family.BAYER else np.s_[:]
    assert np.abs(mono[inside] - luma[inside]).max() <= 1.5


@pytest.mark.parametrize("pixel_format", [f for f in CONVERTIBLE if f.family is Family.BAYER], ids=str)
@pytest.mark.parametrize("colour", "RGB")
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


@pytest.mark.parametrize(("width", "height"), [(1, 1), (2, 1), (1, 4), (2, 2), (5, 2)])
def test_a_bayer_picture_too_small_to_interpolate_is_not_black(width, height):
    values = np.full((height, width), 200)
    rgb = frame_of(values, pfnc.by_name("BayerRG8")).rgb()
    assert rgb.shape == (height, width, 3)
    assert rgb.max() == 200


@pytest.mark.parametrize("pixel_format", [f for f in CONVERTIBLE if f.family is Family.YUV], ids=str)
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


@pytest.mark.parametrize("pixel_format", WHOLE, ids=str)
def test_the_payload_passes_through_without_a_copy(pixel_format):
    frame = frame_of(random_values(pixel_format, 8, 6), pixel_format)
    assert np.shares_memory(frame.raw(), frame.payload)


def test_eight_bit_pictures_pass_through_without_a_copy():
    mono = frame_of(random_values(pfnc.by_name("Mono8"), 8, 6), pfnc.by_name("Mono8"))
    assert np.shares_memory(mono.mono(), mono.payload)
    assert np.shares_memory(pixels.for_display(mono).pixels, mono.payload)
    rgb = frame_of(random_values(pfnc.by_name("RGB8"), 8, 6), pfnc.by_name("RGB8"))
    assert np.shares_memory(rgb.rgb(), rgb.payload)


def test_conversions_are_made_once():
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


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
def test_chunks_behind_the_picture_do_no_harm(pixel_format):
    values = random_values(pixel_format, 7, 5)
    payload = np.frombuffer(encoded(values, pixel_format) + b"\xff" * 40, np.uint8)
    assert np.array_equal(Frame(payload, 7, 5, pixel_format).raw(), values)


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
@pytest.mark.parametrize("padding", [0, 3])
def test_one_byte_too_few_is_an_error_that_counts(pixel_format, padding):
    frame = frame_of(random_values(pixel_format, 7, 5), pixel_format, padding_x=padding)
    needed = frame.payload.size - padding  # the last line's padding may be missing
    frame.payload = frame.payload[: needed - 1]
    for use in (frame.raw, frame.rgb, frame.mono, lambda: pixels.for_display(frame)):
        with pytest.raises(PixelFormatError, match=f"{needed} bytes, the payload has {needed - 1}"):
            use()


@pytest.mark.parametrize("code", [0x81080001, pfnc.by_name("Coord3D_ABC32f").code])
def test_a_format_without_a_picture_names_itself(code):
    frame = Frame(np.zeros(1000, np.uint8), 4, 4, pfnc.by_code(code))
    for use in (frame.raw, frame.rgb, frame.mono, lambda: pixels.value_at(frame, 0, 0)):
        with pytest.raises(PixelFormatError, match=f"0x{code:08X}.*raw bytes can still be saved"):
            use()


def reference_value(values, pixel_format, x, y):
    if pixel_format.family is Family.RGB:
        return tuple(
            int(values[y, x, pixel_format.order.index(c)]) for c in "RGBa" if c in pixel_format.order
        )
    if pixel_format.family is Family.YUV:
        luma, first = pixel_format.order.index("Y"), x - x % 2
        second = first + 1 if first + 1 < values.shape[1] else first
        return tuple(
            int(v) for v in (values[y, x, luma], values[y, first, 1 - luma], values[y, second, 1 - luma])
        )
    return (int(values[y, x]),)


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
def test_the_value_under_the_cursor(pixel_format):
    values = random_values(pixel_format, 7, 5)
    frame = frame_of(values, pixel_format)
    for y in range(5):
        for x in range(7):
            assert pixels.value_at(frame, x, y) == reference_value(values, pixel_format, x, y)


@pytest.mark.parametrize(("x", "y"), [(-1, 0), (0, -1), (7, 0), (0, 5)])
def test_no_value_outside_the_picture(x, y):
    with pytest.raises(IndexError, match="7×5"):
        pixels.value_at(frame_of(np.zeros((5, 7), int), pfnc.by_name("Mono8")), x, y)


@given(
    pixel_format=st.sampled_from(CONVERTIBLE),
    width=st.integers(-1, 40),
    height=st.integers(-1, 12),
    size=st.integers(0, 3000),
    padding=st.integers(-1, 9),
    big_endian=st.booleans(),
)
def test_any_frame_gives_a_picture_or_a_pixel_format_error(
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


def test_a_huge_picture_with_a_tiny_payload_takes_no_memory():
    frame = Frame(np.zeros(10, np.uint8), 2**31, 2**31, pfnc.by_name("Mono12p"))
    with pytest.raises(PixelFormatError):
        frame.rgb()
