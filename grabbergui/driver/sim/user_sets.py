"""Settings that the camera keeps: the factory's, and two of the user's."""

from __future__ import annotations

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.memory import (
    Refusal,
    Register,
    RegisterMemory,
    RegisterRefusedError,
    RegisterValue,
)


class UserSets:
    """What UserSetSave stored, by set. Kept as long as the camera lives, resets included."""

    def __init__(self, memory: RegisterMemory) -> None:
        self._memory = memory
        self._sets = {user_set: self._present() for user_set in reg.UserSet}

    def save(self) -> None:
        """Keep the present settings in the selected set. Raises RegisterRefusedError for the factory's."""
        selected = reg.UserSet(self._memory.integer(reg.USER_SET_SELECTOR))
        if selected is reg.UserSet.DEFAULT:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the factory's user set cannot be overwritten")
        self._sets[selected] = self._present()

    def apply(self, which: Register) -> None:
        """Take over the set that a register names."""
        for register, value in self._sets[reg.UserSet(self._memory.integer(which))].items():
            self._memory.set(register, value)

    def _present(self) -> dict[Register, RegisterValue]:
        return {register: self._memory.stored(register) for register in reg.ALL if register.saved}
