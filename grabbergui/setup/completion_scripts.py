"""The scripts with which bash, zsh and fish ask this program for words, and where they are installed.

Zsh and fish quote the words that they insert into the line. Bash inserts them as they are, so `bash_line`
quotes them.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from grabbergui.core.environment import config_home, data_home
from grabbergui.core.errors import UsageError

_BASH = """\
# Completion of grabbergui for bash; written by `grabbergui setup completion`.
_grabbergui() {
    local reply
    mapfile -t reply < <(PROGRAM --complete bash "${COMP_LINE:0:COMP_POINT}" "$COMP_WORDBREAKS" 2>/dev/null)
    case ${reply[0]} in
        files) compopt -o default ;;
        nospace) compopt -o nospace ;;
    esac
    COMPREPLY=("${reply[@]:1}")
}
complete -F _grabbergui grabbergui
"""
_ZSH = """\
#compdef grabbergui
# Completion of grabbergui for zsh; written by `grabbergui setup completion`.
_grabbergui() {
    local -a reply
    reply=("${(@f)$(PROGRAM --complete zsh "${(@Q)words[1,CURRENT-1]}" "${(Q)PREFIX}" 2>/dev/null)}")
    local directive=$reply[1]
    shift reply
    case $directive in
        files) _files ;;
        nospace) _describe grabbergui reply -S '' ;;
        *) _describe grabbergui reply ;;
    esac
}
if [ "$funcstack[1]" = "_grabbergui" ]; then
    _grabbergui "$@"
else
    compdef _grabbergui grabbergui
fi
"""
_FISH = """\
# Completion of grabbergui for fish; written by `grabbergui setup completion`.
function __grabbergui_words
    set -l word (string unescape -- (commandline -ct); or commandline -ct)
    set -l reply (PROGRAM --complete fish (commandline -opc) "$word" 2>/dev/null)
    if test "$reply[1]" = files
        __fish_complete_path (commandline -ct)
    else
        printf '%s\\n' $reply[2..-1]
    end
end
complete -c grabbergui -f -a '(__grabbergui_words)'
"""
_SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}
SHELLS = tuple(_SCRIPTS)


def script(shell: str, program: Sequence[str]) -> str:
    """Return the script of a shell, one of SHELLS, that asks this program."""
    return _SCRIPTS[shell].replace("PROGRAM", shlex.join(program))


def script_file(shell: str, environment: Mapping[str, str] = os.environ) -> Path:
    """Return where a shell looks for the user's completions; for zsh a folder that `advice` names."""
    if shell == "bash":
        return data_home(environment) / "bash-completion" / "completions" / "grabbergui"
    if shell == "zsh":
        return data_home(environment) / "zsh" / "site-functions" / "_grabbergui"
    return config_home(environment) / "fish" / "completions" / "grabbergui.fish"


def advice(shell: str, file: Path) -> str:
    """Return what the user must still do."""
    if shell == "bash":
        return "takes effect in new shells, with the package bash-completion; without it, source the file"
    if shell == "zsh":
        return f"add to ~/.zshrc, before compinit: fpath=({shlex.quote(str(file.parent))} $fpath)"
    return "takes effect in new shells"


def login_shell(environment: Mapping[str, str] = os.environ) -> str:
    """Return the user's shell, one of SHELLS. Raises UsageError for another one."""
    name = Path(environment.get("SHELL", "")).name
    if name not in SHELLS:
        raise UsageError(
            f"there is no completion for the shell '{name}'; choose one with --shell {'|'.join(SHELLS)}"
        )
    return name


def install(shell: str, program: Sequence[str], environment: Mapping[str, str] = os.environ) -> Path:
    """Write the script of a shell and return where it is. Raises OSError."""
    file = script_file(shell, environment)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(script(shell, program), "utf-8")
    return file


def remove(shell: str, environment: Mapping[str, str] = os.environ) -> Path | None:
    """Remove the script of a shell; return where it was, None where there was none. Raises OSError."""
    file = script_file(shell, environment)
    if not file.exists():
        return None
    file.unlink()
    return file
