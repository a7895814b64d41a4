"""Registrations as a YARP name server writes them, line by line."""

from __future__ import annotations

import pytest

from grabbergui.net.yarp.os.contact import Contact, contacts

LINE = "registration name /grabber ip 192.168.7.8 port 10002 type fast_tcp"
CONTACT = Contact("/grabber", "192.168.7.8", 10002, "fast_tcp")


def test_a_registration_has_one_form() -> None:
    assert Contact.decode(LINE) == CONTACT and CONTACT.encode() == LINE
    assert CONTACT.address == ("192.168.7.8", 10002)
    assert Contact("/a", "localhost", 1).encode() == "registration name /a ip localhost port 1 type tcp"


@pytest.mark.parametrize(("port", "known"), [("0", False), ("1", True), ("65535", True), ("65536", False)])
def test_a_port_number_has_16_bits(port: str, known: bool) -> None:
    contact = Contact.decode(LINE.replace("10002", port))
    assert (contact is not None) is known
    assert contact is None or contact.port == int(port)


@pytest.mark.parametrize(
    "line", ["", "*** end of message", f" {LINE}", LINE.replace("10002", "100020"), LINE.replace("ip ", "")]
)
def test_other_lines_are_no_registrations(line: str) -> None:
    assert Contact.decode(line) is None


def test_an_answer_has_registrations_among_other_lines() -> None:
    other = "registration name /image ip 127.0.0.1 port 10004 type tcp"
    answer = ["registrations of all ports:", LINE, other, "*** end of message"]
    assert contacts(answer) == [CONTACT, Contact("/image", "127.0.0.1", 10004)]
    assert contacts([]) == []
