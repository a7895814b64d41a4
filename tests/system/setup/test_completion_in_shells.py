"""Completion in the shells themselves, on a terminal: every kind of word, and names of strangers.

A stranger names ports, cameras, features and files. A completed word must be one argument of the program,
never a command.
"""

import json
import time

import pytest

from shells import KINDS, Shell, missing

COMPLETED = {
    "grabbergui --log-l\td\treco\tsim:co\t--cod\tff\t": [
        "--log-level", "debug", "record", "sim:colour", "--codec", "ffv1",
    ],
    "grabbergui get sim:bo\tExposureTi\t": ["get", "sim:board", "ExposureTime"],
    "grabbergui set sim: ExposureTi\t5 ExposureAuto=Of\t": [
        "set", "sim:", "ExposureTime=5", "ExposureAuto=Off",
    ],
    "grabbergui save sim: came\t": ["save", "sim:", "camera.yaml"],
}  # fmt: skip
"""Lines as typed, and the arguments that they become."""
FEATURE = "Bad;touch${IFS}1pwned`touch 2pwned`"
VALUE = "Worse$(touch 3pwned)"
FILE = "q;touch 4pwned;'\"`touch 5pwned`&#!x"
NAMES = [
    "/a;touch$IFS'6pwned'$(touch 7pwned)`touch 8pwned`&touch 9pwned|",
    '/b\'"touch|>10pwned<(touch 11pwned)\\\\ #~{x,y}*?[z]=a:b@c∞é"',
    "/c!!!touch'",
]
"""Ports, each of which its second character identifies."""
UNPRINTABLE = ["/u\ntouch 12pwned\n", "/u\x1b[31mred\x07\x9b31m", "/u\u202eabc", "/u\x0btouch 13pwned\r"]


@pytest.fixture(params=KINDS)
def shell(request, tmp_path):
    if reason := missing(request.param):
        pytest.skip(reason)
    cache = tmp_path / "cache" / "grabbergui"
    cache.mkdir(parents=True)
    kept = {
        "sources": {"time": time.time(), "uris": [f"yarp:{name}" for name in [*NAMES, *UNPRINTABLE]]},
        "features": {"u3v:": [FEATURE, "Good"]},
        "values": {"u3v:": {"Good": [VALUE]}},
    }
    (cache / "seen.json").write_text(json.dumps(kept))
    shell = Shell(request.param, tmp_path, {"XDG_CACHE_HOME": str(tmp_path / "cache")})
    yield shell
    shell.close()


def test_every_kind_of_word_in_every_shell(shell):
    (shell.work / "camera.yaml").touch()
    for typed, arguments in COMPLETED.items():
        assert shell.run(typed) == arguments

    files = [FILE, "camera.yaml"]
    (shell.work / FILE).touch()
    for name in NAMES:
        assert shell.run(f"grabbergui get yarp:{name[:2]}\t") == ["get", f"yarp:{name}"]
        assert shell.run(f"grabbergui get 'yarp:{name[:2]}\t") == ["get", f"yarp:{name}"]
        if "!" not in name:  # bash cannot quote it so
            assert shell.run(f'grabbergui get "yarp:{name[:2]}\t') == ["get", f"yarp:{name}"]
    assert shell.run("grabbergui get yarp:/u\t") == ["get", "yarp:/u"]
    assert shell.run("grabbergui get u3v: Ba\t") == ["get", "u3v:", FEATURE]
    assert shell.run("grabbergui set u3v: Ba\t1 Good=W\t") == ["set", "u3v:", f"{FEATURE}=1", f"Good={VALUE}"]
    assert shell.run("grabbergui get file:q\t") == ["get", f"file:{FILE}"]
    assert shell.run("grabbergui diff q\t") == ["diff", FILE]
    assert sorted(path.name for path in shell.work.iterdir()) == sorted(files), "a name was run as a command"
    for unprintable in (b"[31mred", "\u202e".encode(), b"13pwned"):
        assert unprintable not in shell.shown
