import pytest

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import UsageError


@pytest.mark.parametrize(
    ("peer", "allowed"),
    [
        ("10.0.0.7", True),
        ("10.0.1.7", False),
        ("192.168.1.7", True),
        ("192.168.1.8", False),
        ("fd00::5", True),
        ("fd01::5", False),
        ("fd00::5%eth0", True),
        ("::ffff:10.0.0.7", True),
        ("127.0.0.1", True),
        ("::1", True),
        ("nonsense", False),
        ("", False),
    ],
)
def test_who_is_answered(peer, allowed):
    addresses = AllowedAddresses.parse(["10.0.0.9/24", "192.168.1.7", "fd00::/64"])
    assert addresses.allows(peer, "172.16.0.1") is allowed
    assert addresses.allows(peer, peer), "this machine, by its own address"
    assert EVERYBODY.allows(peer)
    assert EVERYBODY.everybody and not addresses.everybody
    assert str(addresses) == "10.0.0.0/24, 192.168.1.7/32, fd00::/64"


@pytest.mark.parametrize("text", ["10.0.0", "10.0.0.0/33", "host", ""])
def test_what_is_no_address(text):
    with pytest.raises(UsageError, match="write an address or a network"):
        AllowedAddresses.parse([text])
