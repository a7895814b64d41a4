"""Vendors' own pixel formats: the right picture, or none."""

import pytest

from every_case import every_case
from grabbergui.core import pfnc, vendor_formats
from grabbergui.core.pfnc import PixelFormat, SampleLayout


@every_case(
    ("code", "name", "vendor", "found"),
    [
        (0x810C0002, "BayerRG12Packed", "Basler", "BayerRG12Packed"),
        (0x810C0002, "", "Basler AG", "BayerRG12Packed"),
        (0x81100009, "", "Basler", "BayerBG16"),
        (0x82100005, "YUV422_YUYV_Packed", "Basler", "YUV422_8"),
        (0x82100005, "", "basler", "YUV422_8"),
        (0x82180001, "RGB8Packed", "Acme", "RGB8"),
        (0x82200001, "RGBA8Packed", "Acme", "RGBa8"),
        (0x82300001, "BGR12Packed", "Acme", "BGR12"),
        (0x82300001, "RGB16Planar", "Acme", "RGB16_Planar"),
        (0x81080123, "Polarized8", "FLIR", "Mono8"),
        (0x810C0123, "Polarized12p", "FLIR", "Mono12p"),
        (0x81080123, "PolarizeMono8", "Acme", "Mono8"),
        (0x0108FFFF, "BayerRG8", "Acme", "BayerRG8"),
        (0x01080009, "Odd", "Acme", "BayerRG8"),
    ],
)
def test_formats_whose_layout_is_known(code, name, vendor, found):
    assert vendor_formats.of_camera(code, name, vendor) is pfnc.by_name(found)


@pytest.mark.parametrize(
    ("code", "name", "vendor", "shown"),
    [
        (0x81080001, "Mono8HB", "Hikrobot", "Mono8HB"),
        (0x81080001, "", "Hikrobot", "Mono8HB"),
        (0x81100007, "", "Hikvision", "Mono16HB"),
        (0x81080123, "BayerRGPolarized8", "FLIR", "BayerRGPolarized8"),
        (0x81080300, "EVT3_0", "LUCID Vision Labs", "EVT3_0"),
        (0x81100001, "Mono8", "Acme", "0x81100001"),
        (0x0108FFFF, "EventData", "Acme", "EventData"),
        (0x810C0002, "", "Acme", "0x810C0002"),
        (0x810C0002, "", "", "0x810C0002"),
    ],
)
def test_what_cannot_be_decoded_is_raw_data_of_that_name(code, name, vendor, shown):
    assert vendor_formats.of_camera(code, name, vendor) == PixelFormat(shown, code, layout=SampleLayout.OTHER)


def test_a_name_of_the_convention_means_the_same_to_a_camera():
    assert all(vendor_formats.named(known.name) is known for known in pfnc.FORMATS)
