"""Groups of mcast: one for all readers on a network, to which one output sends."""

from __future__ import annotations

import pytest

from grabbergui.core.errors import GrabberError, SourceUnavailableError
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.multicast import FALLBACK, MulticastGroups
from grabbergui.net.yarp.os.name_client import NameClient


class Names(NameClient):
    """A name server in memory."""

    def __init__(self, failure: GrabberError | None = None) -> None:
        self.log: list[tuple[str, ...]] = []
        self._failure = failure

    def register(self, name: str, carrier: str = "tcp", ip: str | None = None, port: int = 0) -> Contact:
        if self._failure:
            raise self._failure
        number = sum(line[0] == "register" for line in self.log) + 1
        self.log.append(("register", name, carrier))
        return Contact(f"/tmp/port/{number}", f"224.1.1.{number}", 10000 + number, carrier)

    def set_property(self, name: str, key: str, *values: str) -> None:
        self.log.append(("set", name, key, *values))

    def unregister(self, name: str) -> None:
        self.log.append(("unregister", name))


def test_readers_on_a_network_share_a_group_to_which_one_output_sends() -> None:
    names = Names()
    groups = MulticastGroups("/out", names)
    first, second, elsewhere = (groups.join(host, "mcast") for host in ("10.0.0.1", "10.0.0.1", "10.1.0.1"))
    assert first.address == second.address == ("224.1.1.1", 10001)
    assert elsewhere.address == ("224.1.1.2", 10002)
    assert [member.sends for member in (first, second, elsewhere)] == [True, False, True]

    first.leave()
    first.leave()
    assert [member.sends for member in (first, second)] == [False, True]
    assert ("unregister", "/tmp/port/1") not in names.log, "another reader has it"
    second.leave()
    groups.close(5.0)
    assert names.log == [
        ("register", "...", "mcast"),
        ("set", "/out", "owns", "/tmp/port/1"),
        ("register", "...", "mcast"),
        ("set", "/out", "owns", "/tmp/port/2"),
        ("unregister", "/tmp/port/1"),
    ]
    assert groups.join("10.0.0.1", "mcast").address == ("224.1.1.3", 10003), "its group was given up"


def test_readers_who_ask_for_other_images_have_a_group_of_their_own() -> None:
    groups = MulticastGroups("/out", Names())
    coloured, mono = (groups.join("10.0.0.1", carrier) for carrier in ("mcast", "mcast+pixels.mono"))
    assert coloured.address != mono.address and coloured.sends and mono.sends


@pytest.mark.parametrize("names", [None, Names(SourceUnavailableError("no answer"))])
def test_without_a_name_server_the_group_is_that_of_yarp(names: Names | None) -> None:
    groups = MulticastGroups("/out", names)
    assert groups.join("10.0.0.1", "mcast").address == FALLBACK
