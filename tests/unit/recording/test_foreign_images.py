"""Folders and movies of others: natural order, pages of TIFF, yarpdatadumper, deep movies."""

import contextlib
import struct
import time
import zlib

import av
import cv2
import numpy as np
import PIL.Image
import pytest
from av.video.frame import VideoFrame

from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.recording import tiff_pages
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.opening import open_recording


def played(path):
    with contextlib.closing(open_recording(path)) as recording:
        return [recording.frame(index, 0) for index in range(len(recording))]


def firsts(path):
    return [int(frame.raw().flat[0]) for frame in played(path)]


def flat(value, dtype=np.uint8):
    return np.full((4, 6), value, dtype)


def test_a_folder_is_played_in_natural_order(tmp_path):
    for index, name in enumerate(["frame_1", "frame_2", "frame_10", "frame_11", "frame_100"]):
        cv2.imwrite(str(tmp_path / f"{name}.png"), flat(index))
    assert firsts(tmp_path) == [0, 1, 2, 3, 4]


def test_files_that_other_systems_leave_are_ignored(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), flat(1))
    (tmp_path / "._a.png").write_bytes(b"\0\5\x16\7Mac OS X")
    (tmp_path / ".hidden.png").write_bytes(b"")
    (tmp_path / "Thumbs.db").write_bytes(b"")
    assert firsts(tmp_path) == [1]


def stack(path, dtype=np.uint16, count=5, compression=1):
    images = [flat(100 + index, dtype) + np.arange(24, dtype=dtype).reshape(4, 6) for index in range(count)]
    cv2.imwritemulti(str(path), images, [cv2.IMWRITE_TIFF_COMPRESSION, compression])
    return images


@pytest.mark.parametrize("compression", [1, 5, 32946], ids=["none", "lzw", "deflate"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_each_page_of_opencvs_tiff_is_a_frame(tmp_path, dtype, compression):
    images = stack(tmp_path / "stack.tiff", dtype, compression=compression)
    for path in (tmp_path / "stack.tiff", tmp_path):
        frames = played(path)
        assert [frame.frame_id for frame in frames] == [0, 1, 2, 3, 4]
        assert all(np.array_equal(frame.raw(), image) for frame, image in zip(frames, images, strict=True))


@pytest.mark.parametrize("compression", [None, "tiff_lzw", "tiff_deflate"])
@pytest.mark.parametrize("mode", ["L", "I;16", "RGB", "F"])  # OpenCV multiplies colours by an alpha
def test_each_page_of_pillows_tiff_is_a_frame(tmp_path, mode, compression):
    colour = np.random.default_rng(1).integers(0, 256, (4, 6, 4), np.uint8)
    grey = colour[..., 0]
    array = {
        "L": grey,
        "I;16": grey.astype(np.uint16) * 200,
        "RGB": colour[..., :3],
        "F": grey.astype(np.float32) / 7,
    }[mode]
    first, second = PIL.Image.fromarray(array), PIL.Image.fromarray(array[::-1].copy())
    first.save(tmp_path / "x.tif", save_all=True, append_images=[second], compression=compression)
    frames = played(tmp_path / "x.tif")
    assert len(frames) == 2
    for frame, expected in zip(frames, (array, array[::-1]), strict=True):
        raw = frame.raw() if array.ndim == 2 else frame.rgb()
        assert np.array_equal(raw, expected if array.ndim == 2 else expected[..., :3])


def test_pages_and_files_are_played_one_after_the_other(tmp_path):
    stack(tmp_path / "b_2.tiff", np.uint8, 2)
    stack(tmp_path / "b_10.tiff", np.uint8, 3)
    cv2.imwrite(str(tmp_path / "a.png"), flat(7))
    assert firsts(tmp_path) == [7, 100, 101, 100, 101, 102]


def test_a_stack_of_imagej_has_one_directory(tmp_path):
    """As ImageJ writes stacks beyond 4 GiB; big-endian, as it writes all."""
    images = np.arange(3 * 24, dtype=">u2").reshape(3, 4, 6)
    description = b"ImageJ=1.54f\nimages=3\nslices=3\nloop=false\n\0"
    offset = 8 + 2 + 9 * 12 + 4 + len(description)
    entries = [
        (256, 3, 1, 6), (257, 3, 1, 4), (258, 3, 1, 16), (262, 3, 1, 1), (270, 2, len(description), 122),
        (273, 4, 1, offset), (277, 3, 1, 1), (278, 3, 1, 4), (279, 4, 1, 48),
    ]  # fmt: skip
    content = struct.pack(">2sHIH", b"MM", 42, 8, len(entries))
    for tag, kind, count, value in entries:
        content += struct.pack(">HHI", tag, kind, count) + (
            struct.pack(">HH", value, 0) if kind == 3 else struct.pack(">I", value)
        )
    content += struct.pack(">I", 0) + description
    (tmp_path / "x.tif").write_bytes(content + images.tobytes())
    assert np.array_equal([frame.raw() for frame in played(tmp_path / "x.tif")], images)
    (tmp_path / "x.tif").write_bytes(content + images.tobytes()[:100])  # cut short
    assert len(played(tmp_path / "x.tif")) == 2


def bigtiff(pages):
    """Return a BigTIFF with a directory for each (width, height, data)."""
    content = bytearray(struct.pack("<2sHHHQ", b"II", 43, 8, 0, 16))
    for number, (width, height, data) in enumerate(pages):
        tags = [
            (256, width),
            (257, height),
            (258, 8),
            (262, 1),
            (273, 0),
            (277, 1),
            (278, height),
            (279, len(data)),
        ]
        end = len(content) + 8 + 20 * len(tags) + 8
        content += struct.pack("<Q", len(tags))
        for tag, value in tags:
            content += struct.pack("<HHQQ", tag, 16, 1, end if tag == 273 else value)
        content += struct.pack("<Q", end + len(data) if number < len(pages) - 1 else 0) + data
    return bytes(content)


def test_bigtiff_is_read(tmp_path):
    (tmp_path / "x.tif").write_bytes(bigtiff([(6, 4, bytes([i]) * 24) for i in range(3)]))
    assert firsts(tmp_path / "x.tif") == [0, 1, 2]


def test_hostile_tiff_files_are_refused_or_played_up_to_the_damage(tmp_path):
    good = bigtiff([(6, 4, bytes(24)), (6, 4, bytes(24))])
    loop = bytearray(good)
    loop[16 + 8 + 160 : 16 + 8 + 168] = struct.pack("<Q", 16)  # the first directory follows itself
    path = tmp_path / "x.tif"
    path.write_bytes(loop)
    assert len(tiff_pages.pages_of(path)) == 1
    path.write_bytes(bigtiff([(60000, 60000, b"")]))
    with pytest.raises(RecordingError, match="announces 60000×60000 pixels"):
        played(path)
    with pytest.raises(RecordingError, match="announces 60000×60000 pixels"):
        played(tmp_path)
    path.write_bytes(good[:40])
    with pytest.raises(GrabberError, match=r"x\.tif"):
        played(path)


def test_broken_bytes_of_a_tiff_give_no_traceback(tmp_path):
    stack(tmp_path / "good.tiff", np.uint8, 3, compression=5)
    rng, right = np.random.default_rng(5), 0
    contents = [bigtiff([(6, 4, bytes([i]) * 24) for i in range(3)]), (tmp_path / "good.tiff").read_bytes()]
    for content in contents * 60:
        broken = bytearray(content)
        for at in rng.integers(4, len(content), 2):
            broken[at] = rng.integers(0, 256)
        (tmp_path / "broken.tiff").write_bytes(broken)
        with contextlib.suppress(GrabberError):
            right += len(played(tmp_path / "broken.tiff"))
    assert right > 100


def test_directories_that_overlap_take_no_time(tmp_path):
    """Each of 20,000 directories of 500 tags begins a tag after the one before it."""
    count, tags = 20_000, 500
    content = bytearray(struct.pack("<2sHI", b"II", 42, 8)) + bytes(12 * (count + tags + 2))
    for number in range(count):
        at = 8 + 12 * number
        content[at : at + 2] = struct.pack("<H", tags)
        content[at + 2 + 12 * tags : at + 6 + 12 * tags] = struct.pack("<I", at + 12)
    (path := tmp_path / "x.tiff").write_bytes(content)
    begun = time.process_time()
    with contextlib.suppress(GrabberError):
        played(path)
    assert time.process_time() - begun < 10


def test_other_kinds_of_images_are_not_decoded(tmp_path):
    """OpenCV would decode them, and allocate 3 GiB for what a few bytes announce."""
    content = cv2.imencode(".webp", np.zeros((4, 6, 3), np.uint8))[1].tobytes()
    (tmp_path / "0.png").write_bytes(content)
    with pytest.raises(RecordingError, match="that are no image"):
        played(tmp_path)


def test_a_netpbm_header_announces_no_more_than_can_be(tmp_path):
    (tmp_path / "0.ppm").write_bytes(b"P6\n# a comment\n60000 60000\n255\n" + bytes(100))
    with pytest.raises(RecordingError, match="60000×60000 pixels"):
        played(tmp_path)


def test_a_folder_of_yarpdatadumper_is_played_with_its_times(tmp_path):
    colour = np.full((4, 6, 3), (30, 100, 200), np.uint8)  # B G R
    lines = ["Type: Image:ppm;"]  # the head of older versions
    for index in range(3):
        cv2.imwrite(str(tmp_path / f"{index:08d}.ppm"), colour + index)
        lines.append(f"{17 + index} {1_700_000_000 + index * 0.04:.6f} {index:08d}.ppm")
    (tmp_path / "data.log").write_text("\n".join(lines) + "\n")
    with contextlib.closing(open_recording(tmp_path)) as recording:
        frames = [recording.frame(index, 0) for index in range(len(recording))]
        assert np.allclose(np.diff(recording.times_ns), 40_000_000, atol=1000)
    assert [frame.frame_id for frame in frames] == [17, 18, 19]
    assert frames[1].rgb()[0, 0].tolist() == [201, 101, 31]


def test_the_newer_log_has_two_times_and_the_pixel_code(tmp_path):
    cv2.imwrite(str(tmp_path / "00000000.pgm"), flat(5))
    cv2.imwrite(str(tmp_path / "00000001.pgm"), flat(6))
    (tmp_path / "info.log").write_text("Type: Image;\nStamp: tx+rx;\n[1.0] /cam [connected]\n")
    (tmp_path / "data.log").write_text("1 10.5 99.0 00000000.pgm [mono]\n2 11.0 99.5 00000001.pgm [mono]\n")
    with contextlib.closing(open_recording(tmp_path)) as recording:
        assert recording.times_ns == [10_500_000_000, 11_000_000_000]
    assert firsts(tmp_path) == [5, 6]


@pytest.mark.parametrize("suffix", [".float", ".floatzip"])
def test_depth_of_yarpdatadumper_is_played(tmp_path, suffix):
    depth = np.linspace(0.5, 3, 24, dtype="<f4").reshape(4, 6)
    values = depth.tobytes() if suffix == ".float" else zlib.compress(depth.tobytes())
    (tmp_path / f"00000000{suffix}").write_bytes(struct.pack("<QQ", 4, 6) + values)
    (tmp_path / "data.log").write_text(f"0 1.5 00000000{suffix} [mono float]\n")
    (frame,) = played(tmp_path)
    assert frame.pixel_format.name == "Coord3D_C32f" and np.array_equal(frame.raw(), depth)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (struct.pack("<QQ", 2**40, 2**40), "impossible"),
        (struct.pack("<QQ", 4, 6) + b"abc", "damaged"),
        (struct.pack("<QQ", 4, 6) + zlib.compress(bytes(8)), "only 8 bytes"),
        (b"", "only 0 bytes"),
    ],
)
def test_hostile_depth_is_refused(tmp_path, content, message):
    (tmp_path / "00000000.floatzip").write_bytes(content)
    (tmp_path / "data.log").write_text("0 1.5 00000000.floatzip\n")
    with pytest.raises(RecordingError, match=message):
        played(tmp_path)


def test_the_log_names_no_file_elsewhere(tmp_path):
    (tmp_path / "data.log").write_text("0 1.5 ../secret.png\n1 1.6 /etc/passwd.png\n2 1.7 1 2 3 4\n")
    with pytest.raises(UsageError, match="holds no images"):
        open_recording(tmp_path)


@pytest.mark.parametrize(
    ("bits", "codec"), [(10, "ffv1"), (12, "ffv1"), (10, "libx264"), (10, "libx265"), (12, "libx265")]
)
def test_deep_grey_movies_keep_their_bits(tmp_path, bits, codec):
    images = np.random.default_rng(bits).integers(0, 2**bits, (3, 48, 64), np.uint16)
    options = {"libx264": {"qp": "0"}, "libx265": {"x265-params": "lossless=1:log-level=none"}}.get(codec, {})
    with av.open(str(tmp_path / "x.mkv"), "w") as container:
        stream = container.add_stream(codec, rate=25, options=options)
        stream.width, stream.height, stream.pix_fmt = 64, 48, f"gray{bits}le"
        for image in images:
            frame = VideoFrame(64, 48, f"gray{bits}le")
            plane = np.frombuffer(frame.planes[0], np.uint16).reshape(48, -1)
            plane[:, :64] = image
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    frames = played(tmp_path / "x.mkv")
    assert [frame.pixel_format.name for frame in frames] == [f"Mono{bits}"] * 3
    assert np.array_equal([frame.raw() for frame in frames], images)
