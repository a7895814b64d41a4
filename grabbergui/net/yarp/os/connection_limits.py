"""How many connections a port has, and which one gives way to a new one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Final

from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.outputs import Output

Connection = Input | Output


PORT_LIMIT: Final = 200
"""Connections of one port at a time, in both directions together. Each costs a thread and a descriptor."""

ADDRESS_LIMIT: Final = 64
"""Those of them that lead to one address."""

CROWD: Final = 8
"""Connections to one address of which one is closed when this process runs out of descriptors."""

QUIET_SECONDS: Final = 10.0
"""Between two log entries of one port about strangers, so that a flood does not fill the log."""


def displaced(connections: Sequence[Connection], address: str) -> Connection | None:
    """Return the connection to close for a new one from `address`; None while there is room.

    An address at its limit loses its longest idle connection. A full port closes the longest idle connection
    of the address that has the most.
    """
    own = [connection for connection in connections if connection.address == address]
    if len(own) >= ADDRESS_LIMIT:
        return _idlest(own)
    if len(connections) < PORT_LIMIT:
        return None
    return _idlest(_largest_group(connections))


def expendable(connections: Sequence[Connection]) -> Connection | None:
    """Return one to close so that descriptors become free; None where no address has a crowd of them."""
    group = _largest_group(connections)
    return _idlest(group) if len(group) > CROWD else None


def _idlest(connections: Sequence[Connection]) -> Connection:
    """Return the one that never carried a message, else whose last message is longest ago."""
    return min(connections, key=lambda connection: (connection.messages > 0, connection.active))


def _largest_group(connections: Sequence[Connection]) -> list[Connection]:
    counts = Counter(connection.address for connection in connections)
    crowd = counts.most_common(1)[0][0] if counts else ""
    return [connection for connection in connections if connection.address == crowd]
