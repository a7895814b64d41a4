"""Completion in bash, zsh and fish: a short script each, which asks the program for words.

`grabbergui --complete SHELL …` answers a shell. It must be quick, so it imports neither the parsers of the
commands nor numpy: `cli.reference` makes `resources/completion/commands.json` of the parsers.

The first line of an answer is a directive: `files` (complete file names), `nospace` (the word goes on) or
`words`. Each further line is a word, with its meaning where the shell shows meanings.

The sources and feature names that were seen last are kept in the user's cache, by commands that somebody
types, never by services and scripts.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grabbergui.core.environment import RESOURCES, cache_home, config_home, data_home
from grabbergui.core.errors import UsageError

# -- scripts of the shells -----------------------------------------------------------------------
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
    reply=("${(@f)$(PROGRAM --complete zsh "${(@Q)words[1,CURRENT]}" 2>/dev/null)}")
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
    set -l reply (PROGRAM --complete fish (commandline -opc) (commandline -ct) 2>/dev/null)
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


# -- words ---------------------------------------------------------------------------------------
TABLE = RESOURCES / "completion" / "commands.json"
"""All commands with their arguments."""
_FRESH = 60.0
"""Seconds for which the cameras found by a search are proposed without another search."""
_SEARCH_TIME = 0.25
"""Seconds for a search while the user waits."""
_QUICK = ("gige", "u3v")
"""Kinds of source that are found in this time. `grabbergui list` finds and keeps the others too."""


@dataclass(frozen=True)
class Answer:
    """Words that may replace the one being typed, with their meanings."""

    words: dict[str, str]
    directive: str = "words"


@dataclass(frozen=True)
class Completer:
    """Finds the words that are possible at a place of a command line."""

    table: dict[str, Any]
    "What `commands.json` holds."
    find_sources: Callable[[], Iterable[str]]
    feature_names: Callable[[str], Iterable[str]]
    "The names of a source's features."

    def answer(self, typed: Sequence[str]) -> Answer:
        """Return what can replace the last of the words typed after the program's name."""
        *before, word = typed or [""]
        rest, pending = _without_shared_options(before, self.table["shared"])
        if pending is not None:
            return self._values(pending, word, "")
        if rest:
            # A bare source is the window's.
            known = rest[0] in self.table["commands"]
            command = self.table["commands"][rest[0] if known else "gui"]
            return self._argument(rest[1:] if known else rest, word, command)
        if word.startswith("-"):
            return _matching(_options(self.table["shared"]), word)
        if ":" in word:
            return self._sources(word)
        commands = {name: command["summary"] for name, command in self.table["commands"].items()}
        return _matching(commands, word)

    def _argument(self, before: Sequence[str], word: str, command: dict[str, Any]) -> Answer:
        """Complete an argument of a command: an option, its value, or a positional one."""
        options = {name: option for option in command["options"] for name in option["names"]}
        positionals: list[str] = []
        pending = None
        for each in before:
            if pending is not None:
                pending = None
            elif each in options and options[each]["kind"] != "flag":
                pending = options[each]
            elif not each.startswith("-"):
                positionals.append(each)
        source = positionals[0] if positionals else ""
        if pending is not None:
            return self._values(pending, word, source)
        if word.startswith("--") and "=" in word:
            name, _, value = word.partition("=")
            found = self._values(options.get(name, {"kind": "text"}), value, source)
            return Answer({f"{name}={each}": text for each, text in found.words.items()}, found.directive)
        if word.startswith("-"):
            return _matching({**_options(command["options"]), **_options(self.table["shared"])}, word)
        wanted = command["positionals"]
        if len(positionals) < len(wanted):
            return self._values(wanted[len(positionals)], word, source)
        return self._values(wanted[-1], word, source) if wanted and wanted[-1]["many"] else Answer({})

    def _values(self, argument: dict[str, Any], word: str, source: str) -> Answer:
        """Complete a value of one argument."""
        kind = argument["kind"]
        if kind == "choice":
            return _matching(dict.fromkeys(argument["choices"], ""), word)
        if kind == "source":
            return self._sources(word)
        if kind == "source or file":
            return self._sources(word) if ":" in word else Answer({}, "files")
        if kind == "feature":
            return _matching(dict.fromkeys(self.feature_names(source), ""), word)
        if kind == "assignment":
            return _matching({f"{name}=": "" for name in self.feature_names(source)}, word, "nospace")
        return Answer({}, "files" if kind == "file" else "words")

    def _sources(self, word: str) -> Answer:
        if word.startswith("file:"):
            return _paths(word)
        forms: dict[str, str] = self.table["sources"]
        found = {uri: forms.get(uri, "found") for uri in self.find_sources()}
        matching = _matching({**forms, **found}, word).words
        # A bare kind is a source of its own, or goes on with an address.
        return Answer(matching, "nospace" if all(each.endswith(":") for each in matching) else "words")


def _paths(word: str) -> Answer:
    """Complete the path behind `file:`, which no shell takes for a path."""
    typed = word.removeprefix("file:")
    folder, slash, start = typed.rpartition("/")
    words = {}
    with suppress(OSError):
        for entry in sorted(Path(f"{folder}{slash}" or ".").expanduser().iterdir()):
            if entry.name.startswith(start) and (start or not entry.name.startswith(".")):
                words[f"file:{folder}{slash}{entry.name}{'/' if entry.is_dir() else ''}"] = ""
    return Answer(words, "nospace" if all(each.endswith("/") for each in words) else "words")


def _without_shared_options(
    words: Sequence[str], shared: list[dict[str, Any]]
) -> tuple[list[str], dict[str, Any] | None]:
    """Drop the options that precede the command; also return the one whose value is being typed."""
    options = {name: option for option in shared for name in option["names"]}
    rest = list(words)
    while rest and rest[0].startswith("-"):
        option = options.get(rest.pop(0))
        if option is not None and option["kind"] != "flag":
            if not rest:
                return [], option
            rest.pop(0)
    return rest, None


def _options(options: list[dict[str, Any]]) -> dict[str, str]:
    return {name: option["help"] for option in options for name in option["names"]}


def _matching(words: dict[str, str], word: str, directive: str = "words") -> Answer:
    return Answer({each: meaning for each, meaning in words.items() if each.startswith(word)}, directive)


# -- what was seen -------------------------------------------------------------------------------
_SIMULATED = Path(__file__).parents[1] / "driver" / "sim" / "camera.xml"
_LISTED = re.compile(r"<pFeature>(\w+)</pFeature>")
_CATEGORY = re.compile(r'<Category Name="(\w+)"')
_MOST_CAMERAS = 20
"""Cameras whose features are kept; those seen longest ago are dropped."""


@dataclass
class Seen:
    """The cache of one user: sources and feature names of the last commands.

    Losing the file costs nothing, so errors of reading and writing it are ignored.
    """

    file: Path = field(default_factory=lambda: cache_home() / "grabbergui" / "seen.json")
    clock: Callable[[], float] = time.time

    def sources(self, within: float) -> list[str] | None:
        """Return the URIs of the last search; None if it is older than `within` seconds."""
        entry = self._read().get("sources", {})
        age = self.clock() - _number(entry.get("time") if isinstance(entry, dict) else None)
        return _texts(entry.get("uris")) if 0 <= age <= within else None

    def features(self, uri: str) -> list[str]:
        """Return a source's feature names; the simulated camera's if that source was never open."""
        features = self._read().get("features", {})
        return (_texts(features.get(uri)) if isinstance(features, dict) else []) or simulated_features()

    def keep_sources(self, uris: Iterable[str]) -> None:
        """Remember the result of a search."""
        self._write({**self._read(), "sources": {"time": self.clock(), "uris": list(uris)}})

    def keep_features(self, uri: str, names: Iterable[str]) -> None:
        """Remember a source's feature names."""
        kept = self._read()
        features = kept.get("features", {})
        others = (
            {each: names for each, names in features.items() if each != uri}
            if isinstance(features, dict)
            else {}
        )
        recent = dict(list(others.items())[-_MOST_CAMERAS + 1 :])
        self._write({**kept, "features": {**recent, uri: list(names)}})

    def _read(self) -> dict[str, Any]:
        try:
            kept = json.loads(self.file.read_text("utf-8"))
        except (OSError, ValueError):
            return {}
        return kept if isinstance(kept, dict) else {}

    def _write(self, kept: dict[str, Any]) -> None:
        unfinished = self.file.with_name(f"{self.file.name}.{os.getpid()}")
        with suppress(OSError):
            self.file.parent.mkdir(parents=True, exist_ok=True)
            unfinished.write_text(json.dumps(kept), "utf-8")
            unfinished.replace(self.file)


def somebody_types() -> bool:
    """Return whether this command was typed into a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()


def simulated_features() -> list[str]:
    """Return the feature names of the simulated camera, most of which are SFNC's."""
    description = _SIMULATED.read_text("utf-8")
    return sorted(set(_LISTED.findall(description)) - set(_CATEGORY.findall(description)))


def _texts(value: object) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, list) else []


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


# -- answers to the shells -----------------------------------------------------------------------
def typed_in_bash(line: str) -> list[str]:
    """Split bash's line up to the cursor, where a quotation may still be open; drop the program's name."""
    if not line or line[-1].isspace():
        line += "''"
    for ending in ("", "'", '"'):
        try:
            return shlex.split(line + ending)[1:]
        except ValueError:
            continue
    return [""]


def for_shell(shell: str, found: Answer, word: str, breaks: str = "") -> str:
    """Write an answer as a shell's script expects it.

    Bash replaces only the part of `word` behind the last of the characters `breaks`, its COMP_WORDBREAKS. Zsh
    wants colons in words escaped, and meanings behind one.
    """
    lines = [found.directive]
    for each, meaning in found.words.items():
        short = meaning.replace("\n", " ")
        if shell == "bash":
            cut = max((word.rfind(sign) for sign in ":=" if sign in breaks), default=-1) + 1
            lines.append(each[cut:])
        elif shell == "zsh":
            escaped = each.replace("\\", "\\\\").replace(":", "\\:")
            lines.append(f"{escaped}:{short}" if short else escaped)
        else:
            lines.append(f"{each}\t{short}" if short else each)
    return "\n".join(lines)


def main(arguments: Sequence[str]) -> int:
    """Answer `zsh WORD…`, `fish WORD…`, or `bash LINE COMP_WORDBREAKS`; the first word is the program."""
    shell, *rest = arguments or [""]
    if shell not in SHELLS or not rest:
        print(f"grabbergui: --complete is for the scripts of {', '.join(SHELLS)}", file=sys.stderr)
        return 2
    typed = typed_in_bash(rest[0]) if shell == "bash" else list(rest[1:])
    seen = Seen()
    table = json.loads(TABLE.read_text("utf-8"))
    found = Completer(table, lambda: _find(seen), seen.features).answer(typed)
    print(for_shell(shell, found, (typed or [""])[-1], rest[1] if shell == "bash" and len(rest) > 1 else ""))
    return 0


def _find(seen: Seen) -> list[str]:
    """Return the sources seen a moment ago, or search for cameras now."""
    recent = seen.sources(_FRESH)
    if recent is not None:
        return recent
    from concurrent.futures import ThreadPoolExecutor

    from grabbergui import sources

    with ThreadPoolExecutor(len(_QUICK)) as pool:
        found = pool.map(lambda kind: sources.discover_kind(kind, _SEARCH_TIME), _QUICK)
        uris = [info.uri for infos in found for info in infos]
    seen.keep_sources(uris)
    return uris
