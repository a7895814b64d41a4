"""YARP's environment variables for the ports of a program."""

from __future__ import annotations

import ipaddress
import os
import re

from grabbergui.core.errors import (
    UsageError,
)
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.target import check_port_name


def port_name(name: str) -> str:
    """Return the name of a port that the program calls `name`: YARP_RENAME_x, then YARP_PORT_PREFIX.

    For `/grabber/rpc` x is `grabber_rpc`. Raises UsageError for what names no port.
    """
    variables = {
        key: os.environ.get(key, "") for key in ("YARP_PORT_PREFIX", f"YARP_RENAME{safe_name(name)}")
    }
    prefix, renamed = variables.values()
    try:
        return check_port_name(prefix + (renamed or name))
    except UsageError as error:
        causes = " and ".join(f"{key}={value}" for key, value in variables.items() if value)
        raise UsageError(f"{causes}: {error}" if causes else str(error)) from error


def port_number(name: str) -> int:
    """Return the TCP port for the port that the program calls `name`, 0 for any: YARP_PORTNUMBER_x."""
    variable = f"YARP_PORTNUMBER{safe_name(name)}"
    text = os.environ.get(variable) or "0"
    number = int(text) if re.fullmatch(r"\d{1,5}", text, re.ASCII) else 65536
    if number > 65535:
        raise UsageError(f"{variable}={text} is no TCP port")
    return number


def registered_address() -> str:
    """Return the address under which to register ports if YARP_IP names one, otherwise an empty string.

    A beginning stands for this machine's first address with it. Raises UsageError.
    """
    wanted = os.environ.get("YARP_IP", "")
    if not wanted:
        return ""
    try:
        return str(ipaddress.ip_address(wanted))
    except ValueError:
        local = sockets.local_addresses()
    for address in local:
        if address.startswith(wanted):
            return address
    raise UsageError(f"YARP_IP={wanted} begins no address of this machine: {', '.join(local)}")


def safe_name(name: str) -> str:
    """Return a name as it is part of variables and file names."""
    return re.sub(r"[^0-9A-Za-z]", "_", name)
