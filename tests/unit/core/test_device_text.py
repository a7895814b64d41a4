"""Text of devices in whatever encoding: no character is lost that can be known."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.device_text import text_field, text_of, xml_text


@pytest.mark.parametrize(
    ("raw", "text"),
    [
        (b"Cam\0old\0er", "Cam"),
        (b"full field", "full field"),
        (b" a\x07b\n\0", "ab"),
        (b"K\xc3\xa4fer\0", "Käfer"),
        (b"K\xe4fer\0", "Käfer"),
        (b"caf\xe9", "café"),
        (b"\x80 100\0", "€ 100"),
        (b"\xe2\x82A", "â‚A"),
        (b"\0Cam", ""),
    ],
)
def test_a_string_register_ends_at_its_first_zero(raw, text):
    assert text_field(raw) == text


def test_a_character_that_the_register_cuts_off_is_the_only_one_lost():
    assert text_field("Käfer auf Straße".encode()[:16]) == "Käfer auf Stra\ufffd"


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_utf_8_stays_as_it_is(text):
    assert text_of(text.encode()) == text


@given(st.text(st.characters(max_codepoint=0xFF, min_codepoint=0xA0), max_size=1))
def test_a_single_character_of_latin_1_is_read(text):
    assert text_of(b"a" + text.encode("latin-1") + b" b") == f"a{text} b"


@given(st.binary())
def test_no_bytes_raise(data):
    assert text_of(data).isascii() == data.isascii()


ENCODINGS = {
    "ISO-8859-1": "°C µs ü",
    "iso-8859-15": "20 € ü",
    "windows-1252": "„°C“ µs",
    "windows-1251": "Экспозиция",
    "KOI8-R": "Экспозиция",
    "GB2312": "曝光时间",
    "GBK": "曝光時間",
    "Big5": "曝光時間",
    "Shift_JIS": "露光時間",
    "EUC-JP": "露光時間",
    "EUC-KR": "노출 시간",
    "ISO-2022-JP": "露光時間",
    "UTF-8": "°C 露光",
    "US-ASCII": "C",
}


def document(encoding: str, text: str) -> str:
    return f'<?xml version="1.0" encoding=\'{encoding}\' standalone="no"?><Unit>{text}</Unit>'


@every_case(("encoding", "text"), ENCODINGS.items())
@every_case("before", [b"", b"Dump of camera 12\r\n"])
def test_the_declared_encoding_is_used(encoding, text, before):
    xml = document(encoding, text)
    assert xml_text(before + xml.encode(encoding)) == before.decode() + xml


@pytest.mark.parametrize(
    "encoding", ["utf-16", "utf-32", "utf-16-le", "utf-16-be", "utf-32-le", "utf-32-be", "cp037", "utf-8-sig"]
)
def test_encodings_with_other_letters_than_ascii(encoding):
    xml = document("cp037" if encoding == "cp037" else "UTF-16", "°C ü")
    assert xml_text(xml.encode(encoding)) == xml


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-32-le", "utf-32-be"])
def test_wide_characters_after_other_text(encoding):
    xml = document("UTF-16", "°C ü")
    assert xml_text("Dump\n".encode(encoding) + xml.encode(encoding)) == xml


@pytest.mark.parametrize(
    ("declared", "actual"),
    [
        ("utf-8", "latin-1"),
        ("ascii", "cp1252"),
        ("ISO-8859-1", "utf-8"),
        ("UTF-16", "utf-8"),
        ("UTF-16", "latin-1"),
        ("no-such-encoding", "latin-1"),
        ("zlib", "utf-8"),
        ("unicode_escape", "latin-1"),
    ],
)
def test_text_that_does_not_keep_its_declaration(declared, actual):
    xml = document(declared, "°C µs ü")
    assert xml_text(xml.encode(actual)) == xml


def test_a_document_of_two_encodings():
    """UTF-8, into which somebody pasted a line of Latin-1."""
    xml = document("utf-8", "露光 {}").encode().replace(b"{}", b"\xb0C")
    assert "露光 °C" in xml_text(xml)


def test_characters_that_no_xml_may_contain_are_left_out():
    assert xml_text(b"<Unit>\0\x0b\xb0C\xef\xbf\xbf\t</Unit>") == "<Unit>°C\t</Unit>"


@given(st.binary())
def test_no_document_raises(data):
    assert isinstance(xml_text(data + document("GBK", "x").encode()[:-3] + data), str)
