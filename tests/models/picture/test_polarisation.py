"""A polarised sensor is recognised by the names that its maker gives, and by nothing else."""

import numpy as np
import pytest

from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.features import AccessMode, Category, EnumEntry, Feature, FeatureDescription, FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_code, by_name
from grabbergui.models.picture.polarisation import is_polarised
from grabbergui.models.picture.quantities import is_mosaic


class Camera:
    """Has PixelFormat with these entries, and these other features."""

    def __init__(self, entries=(), features=(), readable=True):
        self._entries, self._names, self._readable = entries, ("PixelFormat", *features), readable

    def feature_tree(self):
        members = (FeatureDescription(name=name, kind=FeatureKind.ENUMERATION) for name in self._names)
        return Category("Root", members=tuple(members))

    def has_feature(self, name):
        return name in self._names

    def feature(self, name):
        if not self._readable:
            raise FeatureAccessError("PixelFormat", "cannot be read")
        entries = tuple(EnumEntry(entry) for entry in self._entries)
        return Feature(name=name, kind=FeatureKind.ENUMERATION, access=AccessMode.READ_WRITE, entries=entries)


@pytest.mark.parametrize(
    ("camera", "polarised"),
    [
        (Camera(["Mono8", "PolarizedAngles_0d_45d_90d_135d_Mono8"]), True),
        (Camera(["PolarizeMono12p"]), True),
        (Camera(["Mono8"], ["PolarizationMode"]), True),
        (Camera(["Mono8", "BayerRG8"], ["PolarityInverter", "LinePolarity"]), False),
        (Camera(["Mono8"]), False),
        (Camera(["PolarizedMono8"], readable=False), False),
    ],
)
def test_only_the_camera_s_names_count(camera, polarised):
    assert is_polarised(camera) is polarised


@pytest.mark.parametrize(
    ("pixel_format", "mosaic"),
    [
        (by_name("Mono8"), True),
        (by_name("Mono12p"), True),
        (by_code(0x81080001), True),
        (by_name("Confidence8"), False),
        (by_name("Data8"), False),
        (by_name("Mono8s"), False),
        (by_name("Coord3D_C16"), False),
        (by_name("R8"), False),
    ],
    ids=str,
)
def test_only_brightness_can_be_a_mosaic(pixel_format, mosaic):
    assert is_mosaic(Frame(np.zeros(64, np.uint8), 4, 4, pixel_format)) is mosaic
