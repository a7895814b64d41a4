"""The reference page of pixel formats, made from the table of formats (`core.pfnc`)."""

from __future__ import annotations

from collections.abc import Iterator

from grabbergui.core.pfnc import FORMATS, Family, Layout, PixelFormat

HEAD = """# Pixel formats

Every pixel format of the Pixel Format Naming Convention (PFNC 2.4) that this program knows by name: {count},
of which {shown} can be shown. Of an unknown code, as of a maker's own format, the layout is guessed from its
bits per pixel.

*Bits* are those of a pixel in the payload and, if other, the significant ones of a sample. *Unpacked as* is
the result of `frame.raw()`: type and components; packed samples have their value in the low bits. *Made by*
is the cost of the conversion:

- **view**: `raw()` is the payload itself; colour takes one pass of OpenCV.
- **OpenCV**: the same, and colour is OpenCV's own conversion.
- **compiled**: a loop of numba's, with the extra `fast`: about twice the time of a plain copy to unpack,
  1.3 times OpenCV's conversion for YUV. Without it, numpy and OpenCV take several passes to the same result.
- **look-up**: one look-up a byte.
- **numpy**: several passes; range images, masks and formats that cameras rarely send.

[Benchmarks](../benchmarks.md#converting-pictures) has figures.
"""
_GREY, _RANGED = "grey", "grey, smallest to largest value"


def pixel_formats_page() -> str:
    """Document every format: name, code, bits, how it is unpacked, shown and how fast."""
    shown = sum(pixel_format.convertible for pixel_format in FORMATS)
    lines = [HEAD.format(count=len(FORMATS), shown=shown)]
    for family, title in TITLES.items():
        formats = [each for each in FORMATS if each.family is family]
        lines += [f"## {title}\n", *_table(formats), ""]
    return "\n".join(lines)


TITLES = {
    Family.MONO: "One value a pixel",
    Family.BAYER: "Bayer",
    Family.SPARSE: "Sparse colour filters",
    Family.RGB: "RGB",
    Family.BICOLOR: "BiColor",
    Family.YUV: "YUV and YCbCr",
    Family.COORDINATES: "Coordinates",
}


def _table(formats: list[PixelFormat]) -> Iterator[str]:
    yield "| name | code | bits | unpacked as | shown as | made by |"
    yield "|---|---|---|---|---|---|"
    for each in formats:
        bits = f"{each.bits_per_pixel}"
        if each.depth != each.bits_per_pixel:
            bits += f", {each.depth}"
        cells = (f"`{each.name}`", f"`0x{each.code:08X}`", bits, unpacked_as(each), shown_as(each))
        yield f"| {' | '.join(cells)} | {made_by(each)} |"


def unpacked_as(pixel_format: PixelFormat) -> str:
    """Return type and components of `Frame.raw`."""
    if not pixel_format.convertible:
        return "–"
    kind = {"u": "uint", "i": "int", "f": "float"}[pixel_format.kind]
    sample = f"{kind}{8 * pixel_format.sample_bytes}"
    return sample if pixel_format.components == 1 else f"{sample} × {pixel_format.components}"


def shown_as(pixel_format: PixelFormat) -> str:
    """Return what a display shows of it."""
    if not pixel_format.convertible:
        return "not shown; its bytes can be saved"
    if pixel_format.needs_range:
        return _RANGED
    if pixel_format.family is Family.YUV:
        matrix = pixel_format.standard or "601"
        return f"colour, BT.{matrix}, {'limited' if pixel_format.standard else 'full'} range"
    if pixel_format.family in (Family.BAYER, Family.SPARSE):
        return "colour, interpolated"
    return _GREY if pixel_format.family is Family.MONO else "colour"


def made_by(pixel_format: PixelFormat) -> str:
    """Return the class of speed, by a format's way through `core.unpacking` and `core.colour`."""
    if not pixel_format.convertible:
        return "–"
    if pixel_format.packed and not pixel_format.planar:
        return "look-up" if pixel_format.depth < 8 else "compiled"
    spread = pixel_format.expands_chroma or pixel_format.layout is Layout.FIELDS or pixel_format.planar
    if spread or pixel_format.needs_range or pixel_format.kind != "u" or pixel_format.depth < 8:
        return "numpy"
    if pixel_format.family in (Family.SPARSE, Family.BICOLOR):
        return "numpy"
    if pixel_format.family is Family.YUV:
        whole = pixel_format.components == 3 or pixel_format.standard == "601"
        return "OpenCV" if whole else "compiled"
    return "view"
