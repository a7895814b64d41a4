"""A feature of every kind that an editor is made for."""

from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind, Representation

K, A, R = FeatureKind, AccessMode, Representation


def feature(kind, value=None, access=A.READ_WRITE, name="F", **more):
    return Feature(name=name, kind=kind, value=value, access=access, **more)


EXPOSURE = feature(K.FLOAT, 10000.0, name="ExposureTime", minimum=10.0, maximum=1e6, unit="us")
WIDTH = feature(K.INTEGER, 640, name="Width", minimum=16, maximum=2448, increment=16)
WIDE = feature(K.INTEGER, 2**62 + 1, name="Timestamp", minimum=0, maximum=2**63 - 1)
FREE = feature(K.FLOAT, 0.1234567890123)
MODE = feature(
    K.ENUMERATION, "On", entries=(EnumEntry("On"), EnumEntry("Off"), EnumEntry("Never", available=False))
)
TEXT = feature(K.STRING, "left", maximum_length=8)
ADDRESS = feature(K.INTEGER, 0xC0A8000A, representation=R.IPV4_ADDRESS, minimum=0, maximum=2**32 - 1)
SWITCH = feature(K.BOOLEAN, True)
BIT = feature(K.INTEGER, 1, representation=R.BOOLEAN, minimum=0, maximum=1)
COMMAND = feature(K.COMMAND, None, A.WRITE_ONLY)
AUTO = feature(
    K.ENUMERATION,
    "Off",
    name="GainAuto",
    entries=(EnumEntry("Off"), EnumEntry("Once"), EnumEntry("Continuous")),
)
