"""`grabbergui force-ip`, `persistent-ip` and `trigger-group`: commands for GigE Vision cameras only."""

from __future__ import annotations

import argparse
from contextlib import ExitStack, closing
from typing import Any

from grabbergui.cli.arguments import count, counted, key, opened, seconds, wait_time
from grabbergui.core.errors import UsageError
from grabbergui.core.frame_period import FRAME_WAIT
from grabbergui.core.grabber import Access
from grabbergui.core.identity import describe
from grabbergui.core.uri import SourceUri
from grabbergui.core.visible_text import print_json, print_line


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "force-ip",
        help="give a GigE Vision camera an address until it restarts",
        example="grabbergui force-ip 00:30:53:12:34:56 192.168.0.10",
    )
    parser.add_argument(
        "mac", metavar="MAC", help="MAC address, from `grabbergui list` or the camera's label"
    )
    parser.add_argument("ip", metavar="IP", help="the new address")
    _add_subnet(parser)
    parser.set_defaults(run=_force_ip)

    parser = commands.add_parser(
        "persistent-ip",
        help="show how a GigE Vision camera gets its address, or set the address that it keeps",
        example="grabbergui persistent-ip gige:GV01 192.168.0.10",
    )
    parser.add_argument("source", metavar="SOURCE", help="gige:, gige:192.168.0.10, gige:SERIAL …")
    parser.add_argument(
        "ip",
        metavar="IP",
        nargs="?",
        default="",
        help="the address to keep; without it, show the current configuration",
    )
    _add_subnet(parser)
    parser.add_argument(
        "--forget", action="store_true", help="use DHCP or a link-local address from the next start on"
    )
    parser.set_defaults(run=_persistent_ip)

    parser = commands.add_parser(
        "trigger-group",
        help="expose several GigE Vision cameras at the same time",
        example="grabbergui trigger-group 1 gige:GV01 gige:GV02 -n 10",
    )
    parser.add_argument(
        "group_key", metavar="GROUP_KEY", type=key, help="the action's group key, such as 1 or 0x10"
    )
    parser.add_argument("sources", metavar="SOURCE", nargs="+", help="the cameras, all of them gige: sources")
    parser.add_argument("-n", "--frames", type=count, default=1, help="number of actions (1)")
    parser.add_argument(
        "--device-key", type=key, default=1, metavar="KEY", help="the action's device key (1)"
    )
    parser.add_argument(
        "--group-mask", type=key, default=1, metavar="MASK", help="the action's group mask (1)"
    )
    parser.add_argument(
        "--ahead", type=seconds, default=0.2, metavar="S", help="schedule each action S seconds ahead (0.2)"
    )
    parser.add_argument(
        "--no-ptp", action="store_true", help="execute each action on arrival, without synchronised clocks"
    )
    parser.add_argument(
        "--timeout",
        type=wait_time,
        metavar="S",
        help=f"longest wait for a frame ({FRAME_WAIT:g}, and two frame periods)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_trigger_group)


def _add_subnet(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "mask", metavar="MASK", nargs="?", default="255.255.255.0", help="the subnet mask (255.255.255.0)"
    )
    parser.add_argument(
        "gateway", metavar="GATEWAY", nargs="?", default="0.0.0.0", help="the gateway (0.0.0.0: none)"
    )


def _force_ip(options: argparse.Namespace) -> int:
    from grabbergui.driver.gige.address_commands import force_ip
    from grabbergui.driver.gige.identity import ForceIp

    force_ip(ForceIp(options.mac, options.ip, options.mask, options.gateway))
    print_line(f"{options.mac} has the address {options.ip} until it restarts; open it as gige:{options.ip}")
    return 0


def _persistent_ip(options: argparse.Namespace) -> int:
    from grabbergui.driver.gige.address_commands import (
        check_addresses,
        forget_address,
        keep_address,
        read_configuration,
    )
    from grabbergui.driver.gige.device import GigeDevice

    uri = SourceUri.parse(options.source)
    if uri.scheme != "gige":
        raise UsageError(f"{uri} is not a GigE Vision camera, so it has no address")
    if options.ip and options.forget:
        raise UsageError("write an address or --forget, not both")
    if options.ip:
        check_addresses(options.ip, options.mask, options.gateway)
    writing = options.ip or options.forget
    device = GigeDevice(uri.name)
    with closing(device):
        device.open(Access.CONTROL if writing else Access.MONITOR)
        if options.ip:
            configuration = keep_address(device, options.ip, options.mask, options.gateway)
        elif options.forget:
            configuration = forget_address(device)
        else:
            configuration = read_configuration(device)
    print_line(f"{describe(device.info)}: {configuration}")
    if writing:
        print_line("restart the camera for this to take effect: unplug it, or `grabbergui run … DeviceReset`")
    return 0


def _trigger_group(options: argparse.Namespace) -> int:
    from grabbergui.rig.action_group import ActionGroup
    from grabbergui.rig.rig_file import TriggerEntry

    class Group(ActionGroup):
        """Names the options of this command in its messages."""

        WITHOUT_PTP = "--no-ptp"
        MORE_AHEAD = "--ahead "

    with ExitStack() as stack:
        cameras = [stack.enter_context(opened(source)) for source in options.sources]
        keys = TriggerEntry(
            "action",
            group_key=options.group_key,
            device_key=options.device_key,
            group_mask=options.group_mask,
            ahead=options.ahead,
        )
        group = Group(cameras, keys, ptp=not options.no_ptp, timeout=options.timeout)
        stack.enter_context(closing(group))
        group.start()
        spreads = [group.fire().skew_ns for _ in range(options.frames)]
    clock, largest = "host" if options.no_ptp else "PTP", max(spreads) / 1000
    if options.json:
        print_json(
            {
                "cameras": len(cameras),
                "actions": len(spreads),
                "clock": clock,
                "spread_us": [spread / 1000 for spread in spreads],
                "largest_spread_us": largest,
            }
        )
    else:
        print_line(
            f"{counted(len(spreads), 'action')} at {counted(len(cameras), 'camera')}; "
            f"their frames' timestamps ({clock} clock) lie at most {largest:.1f} µs apart"
        )
    return 0
