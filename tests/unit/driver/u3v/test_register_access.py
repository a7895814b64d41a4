"""Our host against the answers of a recorded device."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import DeviceStatusError, RemoteProtocolError
from grabbergui.driver.u3v import gencp
from grabbergui.driver.u3v.block_assembler import Block, BlockAssembler
from grabbergui.driver.u3v.bootstrap import Abrm, DeviceInfoDescriptor, Sbrm, read_description, split
from grabbergui.driver.u3v.gencp import CommandId, Packet
from grabbergui.driver.u3v.register_access import RegisterAccess
from grabbergui.driver.u3v.stream_protocol import TransferPlan, is_leader
from grabbergui.driver.u3v.usb import BulkInterface
from u3v_bench import DATA, records

CONTROL = BulkInterface(0, 0x81, 0x01, 1024)


class RecordedHandle:
    """A device that knows the memory which a transcript shows, and nothing else."""

    def __init__(self, name: str) -> None:
        self.memory: dict[int, int] = {}
        self.requests: list[Packet] = []
        for command, answer in zip(records(name, "C"), records(name, "S"), strict=True):
            asked, answered = Packet.decode(command), Packet.decode(answer)
            if asked.command == CommandId.READMEM:
                address, _ = gencp.parse_read_memory(asked.data)
                self.memory.update(enumerate(answered.data, address))

    def write(self, endpoint: int, interface: int, data: bytes, timeout: float) -> None:
        self.requests.append(Packet.decode(data))

    def read_into(self, endpoint: int, interface: int, view: NDArray[np.uint8], timeout: float) -> int:
        request = self.requests[-1]
        address, length = gencp.parse_read_memory(request.data)
        span = range(address, address + length)
        known = all(at in self.memory for at in span)
        data = bytes(self.memory[at] for at in span) if known else b""
        status = 0 if known else gencp.Status.INVALID_ADDRESS
        answer = Packet(status, CommandId.READMEM_ACK, request.request_id, data).encode()
        view[: len(answer)] = np.frombuffer(answer, np.uint8)
        return len(answer)

    def clear_halt(self, endpoint: int) -> None: ...


@pytest.fixture
def registers() -> RegisterAccess:
    return RegisterAccess(RecordedHandle("control_open_read_write.txt"), CONTROL)  # type: ignore[arg-type]


def test_the_recorded_device_is_understood(registers: RegisterAccess) -> None:
    assert text_field(registers.read(Abrm.MANUFACTURER_NAME, 64)) == "Simu"
    sbrm = registers.read_u64(Abrm.SBRM_ADDRESS)
    assert registers.read(sbrm + Sbrm.MAXIMUM_ACKNOWLEDGE_TRANSFER, 4) == (1024).to_bytes(4, "little")
    with pytest.raises(DeviceStatusError, match="invalid address"):
        registers.read(0xDEAD_0000, 4)


@pytest.mark.parametrize("longest", [128, 1024])
def test_the_recorded_description_is_read_in_pieces(registers: RegisterAccess, longest: int) -> None:
    registers.set_longest_transfers(longest, longest)
    xml = read_description(registers.read, registers.read_u64(Abrm.MANIFEST_TABLE_ADDRESS))
    assert xml.startswith(b"<?xml")
    assert xml.rstrip().endswith(b"</RegisterDescription>")
    assert len(xml) == 0x1632


def test_transfer_limits_too_short_for_anything_are_refused(registers: RegisterAccess) -> None:
    with pytest.raises(RemoteProtocolError, match="too short"):
        registers.set_longest_transfers(20, 1024)


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("stream_sync_usbip_64x48_mono8.txt", [3072]),
        ("stream_sync_64x48_mono8.txt", [3072]),
        ("stream_viva_70x50_mono8.txt", [3072, 428]),
    ],
)
def test_recorded_blocks_are_assembled(name: str, sizes: list[int]) -> None:
    transfers = records(name, "D")
    first = next(index for index, transfer in enumerate(transfers) if is_leader(transfer))
    plan = TransferPlan(1024, sizes[0], 1, sizes[1] if sizes[1:] else 0, 0, 1024)
    assembler = BlockAssembler(plan, lambda: np.zeros(8192, np.uint8))
    blocks: list[Block] = []
    for transfer in transfers[first:]:
        request = assembler.next_request()
        request.view[: len(transfer)] = np.frombuffer(transfer, np.uint8)
        block = assembler.complete(request, len(transfer))
        if block is not None:
            blocks.append(block)
    assert blocks
    assert assembler.broken == 0
    for block in blocks:
        assert block.missing == 0
        assert block.received == sum(sizes)


def test_the_recorded_device_info_descriptor_is_found() -> None:
    configuration = _configuration("descriptors_with_device_info.txt")
    described = DeviceInfoDescriptor.find(configuration)
    assert described is not None
    assert described.guid_index == 4
    assert described.encode() in configuration


def test_without_device_info_there_is_none() -> None:
    assert DeviceInfoDescriptor.find(_configuration("descriptors.txt")) is None


def _configuration(name: str) -> bytes:
    lines = [line.split() for line in (DATA / name).read_text().splitlines() if line.startswith("P 80060002")]
    configuration = bytes.fromhex(lines[-1][2])
    assert sum(map(len, split(configuration))) == len(configuration)
    return configuration
