"""The scripts of the shells: which, where, and for whom."""

import pytest

from grabbergui.core.errors import UsageError
from grabbergui.setup import completion_scripts as completion


@pytest.mark.parametrize("shell", completion.SHELLS)
def test_a_script_is_installed_and_removed(shell, tmp_path):
    environment = {"XDG_DATA_HOME": str(tmp_path / "data"), "XDG_CONFIG_HOME": str(tmp_path / "config")}
    file = completion.install(shell, ["/a folder/grabbergui"], environment)
    assert file.is_relative_to(tmp_path) and "'/a folder/grabbergui' --complete" in file.read_text("utf-8")
    assert completion.advice(shell, file)
    assert completion.remove(shell, environment) == file and not file.exists()
    assert completion.remove(shell, environment) is None


def test_the_login_shell_is_chosen():
    assert completion.login_shell({"SHELL": "/usr/bin/zsh"}) == "zsh"
    with pytest.raises(UsageError, match=r"tcsh.*--shell"):
        completion.login_shell({"SHELL": "/bin/tcsh"})
