"""Taking, releasing and reading the control privilege on a control link that answers from memory."""

from __future__ import annotations

from typing import cast

import pytest

from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, GrabberError
from grabbergui.driver.gige import privilege
from grabbergui.driver.gige.bootstrap import BootstrapRegister, ControlPrivilege, GvcpCapability
from grabbergui.driver.gige.control_channel import ControlTiming
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.gvcp import Request, Status, WriteReg
from grabbergui.driver.gige.heartbeat import PRIVILEGE_AND_HOLDER

HOLDER = GvcpCapability.PRIMARY_APPLICATION | GvcpCapability.CONCATENATION


class Registers:
    """A control link to registers in memory; `refusals` raise instead of an answer, one after the other."""

    lost: str | None = None
    abandoned = False

    def __init__(self, *refusals: GrabberError, **values: int) -> None:
        self.refusals = list(refusals)
        self.values = {BootstrapRegister[name]: value for name, value in values.items()}
        self.executed: list[Request] = []
        self.timings: list[ControlTiming | None] = []
        self.last_words: list[Request] = []

    def read_register(self, register: BootstrapRegister) -> int:
        return self.values.get(register, 0)

    def execute(self, request: Request, timing: ControlTiming | None = None) -> bytes:
        self.executed.append(request)
        self.timings.append(timing)
        if self.refusals:
            raise self.refusals.pop(0)
        if request is PRIVILEGE_AND_HOLDER:
            return b"".join(
                self.read_register(BootstrapRegister(a)).to_bytes(4, "big") for a in request.addresses
            )
        return b""

    def send_last(self, request: Request) -> None:
        self.last_words.append(request)

    @property
    def link(self) -> ControlLink:
        return cast(ControlLink, self)


def ccp(value: int) -> WriteReg:
    return WriteReg(((BootstrapRegister.CCP, value),))


def test_control_is_requested_with_the_key_only_from_one_who_may_hand_it_over() -> None:
    plain, keyed = (
        ccp(ControlPrivilege.CONTROL),
        ccp(ControlPrivilege.CONTROL | privilege.SWITCHOVER_KEY << 16),
    )
    for held, take_over, capability, request in (
        (ControlPrivilege.CONTROL, True, GvcpCapability.SWITCHOVER, keyed),
        (ControlPrivilege.EXCLUSIVE, True, GvcpCapability.SWITCHOVER, keyed),
        (ControlPrivilege.CONTROL, False, GvcpCapability.SWITCHOVER, plain),
        (ControlPrivilege.CONTROL, True, GvcpCapability(0), plain),
        (ControlPrivilege(0), True, GvcpCapability.SWITCHOVER, plain),
    ):
        registers = Registers(CCP=held)
        privilege.take(registers.link, "cam", capability, take_over=take_over)
        assert registers.executed == [request]
        assert registers.timings == [privilege.BRIEF if held else None], "a refusal may have no answer"


def test_an_error_that_is_no_refusal_is_passed_on() -> None:
    registers = Registers(DeviceStatusError("busy", Status.BUSY))
    with pytest.raises(DeviceStatusError, match="busy"):
        privilege.take(registers.link, "cam", GvcpCapability(0))


def test_control_without_an_answer_is_given_back() -> None:
    registers = Registers(AckTimeoutError("no answer"))
    with pytest.raises(GrabberError, match="another application controls cam"):
        privilege.take(registers.link, "cam", GvcpCapability(0))
    assert registers.executed == [ccp(ControlPrivilege.CONTROL), ccp(0)]


def test_a_lost_camera_is_released_by_one_datagram() -> None:
    registers = Registers()
    registers.lost = "no answer"
    privilege.release(registers.link, "cam")
    assert (registers.executed, registers.last_words) == ([], [ccp(0)])


@pytest.mark.parametrize("capability", [GvcpCapability.PRIMARY_APPLICATION, GvcpCapability.CONCATENATION])
def test_the_holder_is_read_only_from_a_camera_that_has_all_its_registers(capability: GvcpCapability) -> None:
    registers = Registers(PRIMARY_APPLICATION_PORT=3956, PRIMARY_APPLICATION_IP=0xC0A80002)
    assert privilege.holder_of(registers.link, capability) is None
    assert registers.executed == []
    assert privilege.holder_of(registers.link, HOLDER) == (3956, 0xC0A80002)


def test_a_camera_that_refuses_to_say_who_is_in_control_does_no_harm() -> None:
    registers = Registers(DeviceStatusError("no", Status.INVALID_ADDRESS))
    assert privilege.holder_of(registers.link, HOLDER) is None


def test_of_a_local_controller_without_a_port_it_is_not_known_whether_it_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Such a camera reports the address alone: the controller may well run, so it is not waited for."""
    monkeypatch.setattr(privilege, "_released_in_time", lambda link: pytest.fail("waited"))
    registers = Registers(
        DeviceStatusError("denied", Status.ACCESS_DENIED),
        CCP=ControlPrivilege.CONTROL,
        PRIMARY_APPLICATION_IP=0x7F000001,
    )
    with pytest.raises(GrabberError, match=r"another application at 127\.0\.0\.1 controls cam"):
        privilege.take(registers.link, "cam", GvcpCapability(0))
