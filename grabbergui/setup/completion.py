"""Completion in bash, zsh and fish: a short script each, which asks the program for words.

`grabbergui --complete SHELL …` answers a shell. It must be quick, so it imports neither the parsers of the
commands nor numpy: `scripts/reference.py` makes `resources/completion/commands.json` of the parsers.

The first line of an answer is a directive: `files` (complete file names), `nospace` (the word goes on) or
`words`. Each further line is a word, with its meaning where the shell shows meanings.

Words may come from strangers: names of ports, cameras, features and files. `for_shell` leaves out what no
shell shows as it is, and the rest enters a line quoted.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grabbergui.core.environment import RESOURCES
from grabbergui.core.visible_text import print_line
from grabbergui.setup import bash_line
from grabbergui.setup.completion_scripts import SHELLS
from grabbergui.setup.seen import Seen

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
    "Contents of `commands.json`."
    find_sources: Callable[[], Iterable[str]]
    feature_names: Callable[[str], Iterable[str]]
    "The names of a source's features."
    values: Callable[[str, str], Iterable[str]]
    "The values of a source's feature, if they are few."

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
        if kind == "feature" and "[" in word:
            return self._selector(word, source, "]")
        if kind == "feature":
            return _matching(dict.fromkeys(self.feature_names(source), ""), word)
        if kind == "assignment":
            return self._assignment(word, source)
        return Answer({}, "files" if kind == "file" else "words")

    def _assignment(self, word: str, source: str) -> Answer:
        name, equals, _ = word.rpartition("=")
        if word.count("[") > word.count("]"):
            return self._selector(word, source, "]=")
        if not equals:
            return _matching({f"{name}=": "" for name in self.feature_names(source)}, word, "nospace")
        values = self.values(source, name.partition("[")[0])
        return _matching(dict.fromkeys((f"{name}={value}" for value in values), ""), word)

    def _selector(self, word: str, source: str, end: str) -> Answer:
        """Complete what is in the brackets of `TriggerMode[TriggerSelector=FrameStart]`, up to `end`."""
        feature, _, inside = word.partition("[")
        others, comma, typed = inside.rpartition(",")
        start, selector = f"{feature}[{others}{comma}", typed.partition("=")[0]
        if "=" in typed:
            words = [f"{start}{selector}={entry}{end}" for entry in self.values(source, selector)]
        else:
            names = [name for name in self.feature_names(source) if name.endswith("Selector")]
            # A selector's name mostly begins as its features' do: TriggerSelector, TriggerMode.
            likely = [name for name in names if feature.startswith(name.removesuffix("Selector"))]
            words = [f"{start}{name}=" for name in likely or names]
        return _matching(dict.fromkeys(words, ""), word, "nospace")

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


def for_shell(shell: str, found: Answer, line: bash_line.BashLine | None = None) -> str:
    """Write an answer as a shell's script expects it; for bash, with the line that it enters.

    Words with characters that are not printable are left out: a shell would show them raw, and a newline
    would end the word. Zsh wants colons in words escaped, and meanings behind one.
    """
    lines = [found.directive]
    for each, meaning in found.words.items():
        short = " ".join(meaning.split())
        if not each.isprintable():
            continue
        if line is not None:
            inserted = line.inserted(each)
            if inserted is not None:
                lines.append(inserted)
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
        print_line(f"grabbergui: --complete is for the scripts of {', '.join(SHELLS)}", error=True)
        return 2
    line = bash_line.BashLine.parse(rest[0], "".join(rest[1:])) if shell == "bash" else None
    typed = list(line.words) if line is not None else rest[1:]
    seen = Seen()
    table = json.loads(TABLE.read_text("utf-8"))
    found = Completer(table, lambda: _find(seen), seen.features, seen.values).answer(typed)
    sys.stdout.write(for_shell(shell, found, line) + "\n")  # the words themselves, for the shell's script
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
