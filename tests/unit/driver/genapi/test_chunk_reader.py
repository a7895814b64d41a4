"""Chunks behind images: the layout alone, and through the whole driver on the simulated camera's wire."""

import struct

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.features import Category, FeatureDescription, FeatureKind
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi.chunk_reader import LARGEST_CHUNK, MOST_CHUNKS, ChunkReader, without_images

GEV = DataLayout.GIGE_VISION


def payload_of(*chunks):
    """Chunks as GigE Vision lays them out: data, id, length."""
    laid_out = (data + struct.pack(">II", key, len(data)) for key, data in chunks)
    return np.frombuffer(b"".join(laid_out), np.uint8)


def test_an_image_is_cut_down_to_its_tag():
    whole = payload_of((1, bytes(LARGEST_CHUNK + 1)), (2, b"eight by"))
    assert without_images(whole, GEV) == payload_of((1, b""), (2, b"eight by")).tobytes()


def test_lengths_that_lead_out_of_the_payload_give_nothing():
    assert without_images(payload_of((1, b"data"))[1:], GEV) == b""
    assert without_images(np.frombuffer(struct.pack(">II", 1, 0xFFFFFFFF), np.uint8), GEV) == b""
    assert without_images(np.zeros(8 * (MOST_CHUNKS + 1), np.uint8), GEV) == b""


@given(st.binary(max_size=200), st.sampled_from(list(DataLayout)))
def test_any_bytes_give_no_more_than_went_in(data, layout):
    assert len(without_images(np.frombuffer(data, np.uint8), layout)) <= len(data)


@given(st.lists(st.tuples(st.integers(0, 0xFFFFFFFF), st.binary(max_size=40)), max_size=20))
def test_small_chunks_pass_as_they_are(chunks):
    payload = payload_of(*chunks)
    assert without_images(payload, GEV) == payload.tobytes()


_TEXT_AND_NUMBER = b"""<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="C" VendorName="V" StandardNameSpace="None" SchemaMajorVersion="1"
 SchemaMinorVersion="1" SchemaSubMinorVersion="0" MajorVersion="1" MinorVersion="0" SubMinorVersion="0"
 ProductGuid="11111111-2222-3333-4444-555555555555" VersionGuid="11111111-2222-3333-4444-555555555556"
 xmlns="http://www.genicam.org/GenApi/Version_1_1">
<Category Name="Root"><pFeature>ChunkDataControl</pFeature></Category>
<Category Name="ChunkDataControl"><pFeature>ChunkText</pFeature><pFeature>ChunkNumber</pFeature></Category>
<StringReg Name="ChunkText"><Address>0</Address><Length>4</Length><AccessMode>RO</AccessMode>
 <pPort>TextPort</pPort></StringReg>
<IntReg Name="ChunkNumber"><Address>0</Address><Length>4</Length><AccessMode>RO</AccessMode>
 <pPort>NumberPort</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
<Port Name="Device"/>
<Port Name="TextPort"><ChunkID>1001</ChunkID></Port><Port Name="NumberPort"><ChunkID>1002</ChunkID></Port>
</RegisterDescription>"""


def test_a_text_chunk_of_another_encoding_is_read():
    descriptions = (
        FeatureDescription(name="ChunkText", kind=FeatureKind.STRING, category=""),
        FeatureDescription(name="ChunkNumber", kind=FeatureKind.INTEGER, category=""),
    )
    reader = ChunkReader(_TEXT_AND_NUMBER, Category("Root", members=descriptions), GEV)
    number = (0x1002, (7).to_bytes(4, "big"))
    assert reader.read(payload_of((0x1001, b"left"), number)) == {"ChunkText": "left", "ChunkNumber": 7}
    assert reader.read(payload_of((0x1001, b"20\xb0C"), number)) == {"ChunkText": "20°C", "ChunkNumber": 7}
