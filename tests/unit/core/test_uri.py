import os
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui import sources
from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SourceUri, U3vOptions, YarpOptions, read_options


@pytest.mark.parametrize(
    ("text", "scheme", "name", "options"),
    [
        ("sim:", "sim", "", {}),
        (" SIM: ", "sim", "", {}),
        ("gige:192.168.0.10", "gige", "192.168.0.10", {}),
        ("gige://192.168.0.10", "gige", "192.168.0.10", {}),
        ("gige:00:11:1c:f0:00:01", "gige", "00:11:1c:f0:00:01", {}),
        ("yarp:/grabber?carrier=mjpeg&poll=", "yarp", "/grabber", {"carrier": "mjpeg", "poll": ""}),
        ("gige:my%20camera", "gige", "my camera", {}),
    ],
)
def test_uris_as_users_type_them(text, scheme, name, options):
    uri = SourceUri.parse(text)
    assert (uri.scheme, uri.name, uri.options) == (scheme, name, options)
    assert SourceUri.parse(str(uri)) == uri


@pytest.mark.parametrize("text", ["", "camera", "192.168.0.10", ":x", "1a:b", "gige cam:", "sim:?fast"])
def test_a_malformed_uri_is_refused(text):
    with pytest.raises(UsageError, match="'"):
        SourceUri.parse(text)


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("192.168.0.10", "did you mean gige:192.168.0.10?"),
        ("00:30:53:12:34:56", "did you mean gige:00:30:53:12:34:56?"),
        ("/tmp/movie.mp4", "did you mean file:/tmp/movie.mp4?"),
        ("~/scenes", "did you mean file:~/scenes?"),
        ("/dev/video2", "did you mean v4l2:/dev/video2?"),
        ("/grabber", "did you mean yarp:/grabber, ros2:/grabber or file:/grabber?"),
        ("GV01", "write its kind first, as in sim: or gige:192.168.0.10"),
        ("22.3", "write its kind first, as in sim: or gige:192.168.0.10"),
    ],
)
def test_a_name_without_its_kind_is_answered_with_the_likely_one(text, hint):
    with pytest.raises(UsageError) as refused:
        SourceUri.parse(text)
    assert str(refused.value) == f"'{text}' is no source; {hint}"


@given(st.from_regex(r"\A[a-z][a-z0-9]{0,5}\Z"), st.text(), st.dictionaries(st.text(min_size=1), st.text()))
def test_every_source_is_read_back_from_its_text(scheme, name, options):
    # Blanks around a URI are the user's; within the text of one they are written as %20.
    uri = SourceUri(scheme, name, options)
    assert SourceUri.parse(str(uri)) == uri


def test_names_of_files_that_are_no_utf8_are_read_back():
    uri = SourceUri("file", os.fsdecode(b"caf\xe9"))
    assert str(uri) == "file:caf%E9"
    assert SourceUri.parse(str(uri)) == uri


@given(st.text())
def test_any_text_is_a_uri_or_a_usage_error(text):
    with suppress(UsageError):
        assert SourceUri.parse(text).scheme.islower()


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("gige:10.0.0.256", "10.0.0.256 is no IPv4 address"),
        ("gige:192.168.010.5", "without leading zeros"),
        ("gige:10.0.0", "10.0.0 is no IPv4 address"),
        ("gige:127.0.0.1:3956", "write gige:127.0.0.1$"),
        ("gige:10.0.0.1:80", "listen at port 3956 only; write gige:10.0.0.1$"),
    ],
)
def test_a_wrong_address_is_called_one(text, remedy):
    """It was searched for as a serial number."""
    with pytest.raises(UsageError, match=remedy):
        sources.create(text)


@pytest.mark.parametrize("text", ["gige:192.168.0.10", "gige:40012345", "gige:1.5", "gige:00:11:1c:f0:00:01"])
def test_other_names_of_cameras_stay(text):
    assert sources.create(text).info.uri == text


@every_case(
    ("text", "kind", "name", "value"),
    [
        ("u3v:?transfers=1", U3vOptions, "transfers", 1),
        ("u3v:?transfers=1024", U3vOptions, "transfers", 1024),
        ("u3v:?transfers=0", U3vOptions, "transfers", None),
        ("u3v:?transfers=1025", U3vOptions, "transfers", None),
        ("u3v:?transfers=many", U3vOptions, "transfers", None),
        ("yarp:/a?components=0", YarpOptions, "components", False),
        ("yarp:/a?components=", YarpOptions, "components", True),
        ("yarp:/a?components=no", YarpOptions, "components", False),
        ("yarp:/a?components=maybe", YarpOptions, "components", None),
        ("yarp:/a", YarpOptions, "components", True),
    ],
)
def test_an_option_has_a_value_that_is_allowed(text, kind, name, value):
    if value is None:
        with pytest.raises(UsageError, match=f"{name}=.*: write "):
            read_options(kind, SourceUri.parse(text))
    else:
        assert getattr(read_options(kind, SourceUri.parse(text)), name) == value


def test_an_unknown_option_is_answered_with_those_that_there_are():
    with pytest.raises(UsageError, match="there are carrier, nameserver, bind, components"):
        read_options(YarpOptions, SourceUri.parse("yarp:/a?x=1"))
    with pytest.raises(UsageError, match=r"no option carier; did you mean carrier\?"):
        read_options(YarpOptions, SourceUri.parse("yarp:/a?carier=tcp"))
