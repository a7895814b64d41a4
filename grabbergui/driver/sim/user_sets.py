"""The simulated camera's user sets, which are files."""

from __future__ import annotations

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import File, FileState, UserSetSelector
from grabbergui.driver.sim.file_store import FileStore
from grabbergui.driver.sim.memory import (
    Refusal,
    Register,
    RegisterKind,
    RegisterMemory,
    RegisterRefusedError,
    RegisterValue,
)

_FILE_OF_SET = {UserSetSelector.USER_SET1: File.USER_SET1, UserSetSelector.USER_SET2: File.USER_SET2}
_SAVED_REGISTERS = {register.name: register for register in reg.ALL if register.saved}


class UserSets:
    """The user sets stored by UserSetSave: files of the camera, which survive resets and power cuts.

    A file has a line `register = value` for each setting; omitted settings have the factory's values.
    """

    def __init__(self, memory: RegisterMemory, store: FileStore) -> None:
        self._memory = memory
        self._store = store
        self._factory = self._present()
        for file in _FILE_OF_SET.values():
            if store.state(file) is FileState.EMPTY:
                store.replace(file, _encode_settings(self._factory))

    def save(self) -> None:
        """Keep the present settings in the selected set. Raises RegisterRefusedError for the factory's."""
        selected = UserSetSelector(self._memory.integer(reg.USER_SET_SELECTOR))
        if selected is UserSetSelector.DEFAULT:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the factory's user set cannot be overwritten")
        self._store.replace(_FILE_OF_SET[selected], _encode_settings(self._present()))

    def apply(self, which: Register) -> None:
        """Take over the set that a register names.

        Raises RegisterRefusedError, and changes nothing, if its file is incomplete or makes no sense.
        """
        selected = UserSetSelector(self._memory.integer(which))
        settings = dict(self._factory)
        if selected in _FILE_OF_SET:
            file = _FILE_OF_SET[selected]
            if self._store.state(file) is not FileState.INTACT:
                raise RegisterRefusedError(
                    Refusal.ACCESS_DENIED, f"the file of {selected.name} is incomplete"
                )
            settings |= _decode_settings(self._store.content(file))
        for register, value in settings.items():
            self._memory.set(register, value)

    def apply_or_factory(self, which: Register) -> None:
        """Take over the set that a register names; the factory's if that one is damaged."""
        try:
            self.apply(which)
        except RegisterRefusedError as error:
            self._store.note(f"the factory's settings are used: {error}")
            for register, value in self._factory.items():
                self._memory.set(register, value)

    def _present(self) -> dict[Register, RegisterValue]:
        return {register: self._memory.stored(register) for register in reg.ALL if register.saved}


def _encode_settings(settings: dict[Register, RegisterValue]) -> bytes:
    return "".join(f"{register.name} = {value}\n" for register, value in settings.items()).encode()


def _decode_settings(content: bytes) -> dict[Register, RegisterValue]:
    """Return the settings in the file of a user set. Raises RegisterRefusedError."""
    settings: dict[Register, RegisterValue] = {}
    for line in content.decode("utf-8", "replace").splitlines():
        name, _, text = line.partition(" = ")
        register = _SAVED_REGISTERS.get(name)
        if register is None:
            raise RegisterRefusedError(
                Refusal.INVALID_PARAMETER, f"the user set has no setting {name[:40]!r}"
            )
        try:
            value = float(text) if register.kind is RegisterKind.FLOAT64 else int(text)
        except ValueError as error:
            message = f"the user set's {name} is not a number: {text[:40]!r}"
            raise RegisterRefusedError(Refusal.INVALID_PARAMETER, message) from error
        register.check(value)
        settings[register] = value
    return settings
