import errno

import pytest

from every_case import every_case
from grabbergui.core.errors import (
    LocalProtocolError,
    SourceUnavailableError,
    UsageError,
)
from grabbergui.net.yarp.os import configuration, name_server
from grabbergui.net.yarp.os.carrier import TCP, by_name
from grabbergui.net.yarp.os.configuration import authentication_key, parse_address
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import (
    ASKER_LIMIT,
    PORTS_LIMIT,
    PROPERTY_BYTES,
    NameDatabase,
)
from grabbergui.net.yarp.os.target import PORT_NAME_LIMIT, Target, check_port_name, literal_address
from yarp_transcripts import read


def test_our_name_database_answers_as_yarps_does():
    books = NameDatabase(Contact("/root", "127.0.0.1", 10000))
    for contact in (("/grabber", 10003), ("/grabber/rpc", 10002), ("/grabber/quit", 10005)):
        books.answer(f"register {contact[0]} tcp 127.0.0.1 {contact[1]}", "127.0.0.1")
    books.answer("register /fakeFrameGrabber/rpc tcp 127.0.0.1 10004", "127.0.0.1")
    books.answer("register ...", "127.0.0.1")
    compared = 0
    for conversation in read("ns_commands_312"):
        if not conversation.client.startswith(b"NAME_SERVER ") or conversation.client.count(b"\n") > 1:
            continue
        command = conversation.client.decode().removeprefix("NAME_SERVER ").strip()
        answer = books.answer(command, "127.0.0.1")
        recorded = conversation.server.decode()
        if "... " in command:  # numbers that the server chose: only their form can agree
            assert len(answer.split()) == len(recorded.split())
        elif "list" not in command:
            assert answer == recorded, command
        compared += 1
    assert compared > 25


def test_lists_are_alphabetic_and_prefixes_whole_words():
    books = NameDatabase(Contact("/root", "127.0.0.1", 10000))
    for name in ("/b", "/a/x", "/a", "/ab"):
        books.answer(f"register {name}", "10.0.0.7")
    assert [line.split()[2] for line in books.answer("list /a", "").splitlines()[:-1]] == ["/a", "/a/x"]
    assert books.answer("query /ab", "").split()[4] == "10.0.0.7"


def test_the_names_of_all_askers_together_are_limited(monkeypatch):
    monkeypatch.setattr(name_server, "ASKER_LIMIT", 3)
    monkeypatch.setattr(name_server, "PORTS_LIMIT", 5)
    books = NameDatabase(Contact("/root", "127.0.0.1", 10000))
    own = books.answer("list", "").count("registration")
    answers = [books.answer(f"register /n{number} tcp h 5", f"10.0.0.{number}") for number in range(9)]
    assert ["registration" in answer for answer in answers] == [number < 5 - own for number in range(9)]


def test_the_name_database_is_bounded():
    books = NameDatabase(Contact("/root", "127.0.0.1", 10000))
    for number in range(PORTS_LIMIT + 5):
        books.answer(f"register /n{number} tcp h 5", "10.0.0.1")
    assert books.answer("list", "").count("/n") == ASKER_LIMIT
    refused = "*** end of message\r\n"
    assert books.answer("register /mine", "10.0.0.1") == refused
    assert books.answer("register /mine", "10.0.0.2") != refused, "others find names left"
    assert books.answer("register bad tcp h 5", "10.0.0.2") == refused
    assert books.answer(f"register /{'n' * 1000}", "10.0.0.2") == refused
    assert books.answer(f"register /mine tcp {'h' * 1000}", "10.0.0.2") == refused
    for number in range(PROPERTY_BYTES):
        books.answer(f"set /mine key{number} value", "10.0.0.2")
    kept = [books.answer(f"get /mine key{number}", "") for number in range(PROPERTY_BYTES)]
    assert sum("= value" in answer for answer in kept) < PROPERTY_BYTES / len("key0value")


@pytest.mark.parametrize(
    "command", ["register /root tcp 10.6.6.6 666", "bot register /root", "unregister /root"]
)
def test_the_name_servers_own_name_stays_its_own(command):
    books = NameDatabase(Contact("/root", "127.0.0.1", 10000))
    books.answer(command, "10.6.6.6")
    assert books.answer("query /root", "").startswith("registration name /root ip 127.0.0.1 port 10000 ")


@pytest.mark.parametrize("port", ["0", "65536", "9" * 5000], ids=["none", "too large", "endless"])
def test_numbers_that_are_no_port_are_no_address(port):
    assert Contact.decode(f"registration name /x ip 127.0.0.1 port {port} type tcp") is None
    assert literal_address(f"tcp://127.0.0.1:{port}/") is None
    with pytest.raises(UsageError, match="HOST:PORT"):
        parse_address(f"127.0.0.1:{port}")


def test_the_server_is_found_as_yarp_finds_it(tmp_path, monkeypatch):
    for name in ("XDG_CONFIG_HOME", "YARP_NAMESPACE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("YARP_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path / "nowhere"))
    monkeypatch.setenv("YARP_CONFIG_DIRS", str(tmp_path / "nowhere"))
    assert configuration.name_server() is None
    (tmp_path / "yarp.conf").write_text("10.1.2.3 10500 yarp\n")
    assert configuration.name_server() == Contact("/root", "10.1.2.3", 10500)
    (tmp_path / "yarp.conf").write_text("[name]\nhost 10.1.2.4\nport 10600\n")
    assert configuration.name_server() == Contact("/root", "10.1.2.4", 10600)
    (tmp_path / "yarp_namespace.conf").write_text("/my/root\n")
    (tmp_path / "_my_root.conf").write_text("10.1.2.5\n")
    assert configuration.name_server() == Contact("/my/root", "10.1.2.5", 10000)
    monkeypatch.setenv("YARP_NAMESPACE", "/my/root /another")
    assert configuration.name_server() == Contact("/my/root", "10.1.2.5", 10000)
    assert authentication_key() is None
    (tmp_path / "auth.conf").write_text('[AUTH]\nkey "our secret"\n')
    assert authentication_key() == b"our secret"
    assert NameClient.find("robot:11000").server.address == ("robot", 11000)
    with pytest.raises(UsageError, match="HOST:PORT"):
        NameClient.find("robot:99999")


@pytest.mark.parametrize("text", ["robot 99999 yarp", "[NAME]\nport 7", "[ROBOT]\nhost here", "a:b 10000"])
def test_a_configuration_without_an_address_is_named(tmp_path, monkeypatch, text):
    monkeypatch.delenv("YARP_NAMESPACE", raising=False)
    monkeypatch.setenv("YARP_CONFIG_HOME", str(tmp_path))
    (tmp_path / "yarp.conf").write_text(text)
    with pytest.raises(UsageError, match=r"/yarp\.conf: '.*' is no address of a name server; `yarp conf"):
        NameClient.find()


def test_a_configuration_that_may_not_be_read_is_named_and_not_passed_over(tmp_path, monkeypatch):
    def refused(path, *arguments):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setenv("YARP_CONFIG_HOME", str(tmp_path))
    (tmp_path / "auth.conf").touch()
    monkeypatch.setattr(configuration, "read_bounded", refused)
    with pytest.raises(SourceUnavailableError, match=r"auth\.conf could not be read: Permission denied"):
        NameClient.find("127.0.0.1:10000")


@every_case(
    ("text", "target"),
    [
        ("/reader", Target("/reader", "tcp")),
        ("tcp://reader", Target("/reader", "tcp")),
        ("udp:/reader/deep", Target("/reader/deep", "udp")),
        ("fast_tcp+recv.bayer+order.bggr://r", Target("/r", "fast_tcp+recv.bayer+order.bggr")),
        ("tcp://127.0.0.1:99/", Target("//127.0.0.1:99", "tcp")),
        ("udp://[::1]:65535", Target("//::1:65535", "udp")),
        ("//h:1/", Target("//h:1", "tcp")),
        ("tcp://h:0/", Target("/h:0/", "tcp")),
        ("tcp://h:65536", Target("/h:65536", "tcp")),
        ("/udp:/Xsens", Target("/Xsens", "udp")),
        ("udp://Xsens:/b", Target("/Xsens:/b", "udp")),
        ("/a/b:/c", Target("/a/b:/c", "tcp")),
    ],
)
def test_targets_in_yarps_spellings(text, target):
    assert Target.parse(text) == target
    assert Target.parse(text, "fast_tcp") == Target(target.name, "fast_tcp")


def test_a_target_without_a_slash_names_no_port():
    with pytest.raises(LocalProtocolError, match="'reader' names no port"):
        Target.parse("reader")


def test_modifiers_travel_in_the_senders_name():
    target = Target.parse("tcp+recv.portmonitor+file.my.lua+log://reader")
    assert target.modifiers == {"recv": "portmonitor", "file": "my.lua", "log": ""}
    assert target.sender("/grabber") == "/grabber (recv portmonitor) (file my.lua) (log 1)"
    assert by_name(target.carrier) is TCP


@pytest.mark.parametrize("name", ["", "x", "/", "/a b", "/a\nregister /b", '/"', "/" + PORT_NAME_LIMIT * "n"])
def test_bad_port_names_never_reach_the_server(name):
    with pytest.raises(UsageError, match="cannot name a port"):
        check_port_name(name)
    assert check_port_name("/" + (PORT_NAME_LIMIT - 1) * "n")
