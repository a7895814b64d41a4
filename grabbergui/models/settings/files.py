"""Settings files: GenICam's persistence format, and human-readable YAML.

GenApi's feature bag, pylon (`.pfs`) and other viewers write the persistence format: a first line with a
GUID, comment lines, then `Name<TAB>Value` lines, which are written to a camera from top to bottom. A
selector's line precedes the lines of the features that it selects. Enumerations are written by entry,
booleans as 0 and 1.

The YAML has one line for each setting, `BalanceRatio[BalanceRatioSelector=Red]: 1.5`, which suits `diff`.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from grabbergui.core.environment import write_whole
from grabbergui.core.errors import LocalFileError, MissingFileError, UsageError
from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.json_text import to_json
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.settings import SettingKey
from grabbergui.models.settings import foreign
from grabbergui.models.settings.feature_set import FeatureSet, SelectorsOf

BAG_GUID = "{05D8C294-F295-4dfb-9D01-096BD04049F4}"
"First line of a file of one set."
BAGGER_GUID = "{4709CB3C-7322-4460-84C3-DA11DDA09939}"
"First line of a file of several user sets."
MAX_FILE_BYTES = 4 * 1024 * 1024
MAX_LINES = 100_000
"Most lines of a file. Cameras have a few thousand settings."
YAML_SUFFIXES = (".yaml", ".yml")
SETTINGS_SUFFIXES = (*YAML_SUFFIXES, ".pfs")
"Suffixes of settings files among the files that the window opens."

_NAME = r"[A-Za-z_][A-Za-z0-9_]*"
_ENTRY = re.compile(r"[\w.:+-]{1,200}")
"An entry of a selector: a name, or the number of an index."
_YAML_LINE = re.compile(r"( *)((?:[^\s:\[\]#]+(?:\[[^\]]*\])?))\s*:(?:\s+(.*))?")
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*", re.ASCII)
_INTEGER = re.compile(r"[-+]?\d{1,20}", re.ASCII)
_FLOAT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,3})?", re.ASCII)
_YAML_WORDS = frozenset(["true", "false", "yes", "no", "on", "off", "null", "y", "n"])
"Plain scalars that YAML 1.1 does not read as text."
_MOST_SELECTORS = 64
"Most selectors that are distinguished without the camera, as each feature is compared with all of them."


class SettingsFileError(LocalFileError):
    """A settings file could not be read or written."""


def save(features: FeatureSet, path: Path) -> None:
    """Write a set: `.yaml` and `.yml` as YAML, anything else in GenICam's format.

    The file is replaced as a whole, and only if it is empty or a settings file. Raises SettingsFileError,
    MissingFileError, UsageError.
    """
    if path.is_file() and path.stat().st_size:
        load(path)
    text = to_yaml(features) if path.suffix.lower() in YAML_SUFFIXES else to_persistence(features)
    try:
        write_whole(path, text)
    except FileNotFoundError as error:
        raise MissingFileError(f"there is no folder {path.absolute().parent} for {path.name}") from error
    except OSError as error:
        raise SettingsFileError.of(path, "written", error) from error


def load(path: Path, selectors_of: SelectorsOf | None = None) -> FeatureSet:
    """Read a set in either format, recognised by its content.

    The persistence format does not contain the selectors of a feature: `selectors_of` returns them, best from
    the camera itself. Without it, a feature that occurs repeatedly is assumed to be selected by the selectors
    that changed in between. An invalid line is skipped and named in `lost_lines`. Raises SettingsFileError,
    MissingFileError, and UsageError for anything but a settings file.
    """
    try:
        content = read_bounded(path, MAX_FILE_BYTES, "file of settings")
    except FileNotFoundError as error:
        raise MissingFileError(f"there is no file of settings {path}") from error
    except OSError as error:
        raise SettingsFileError.of(path, "read", error) from error
    text = foreign.text_of(content)
    if text is None:
        raise UsageError(f"{path} is no file of settings: it is not text")
    return parse(text, str(path), selectors_of)


def parse(text: str, where: str, selectors_of: SelectorsOf | None = None) -> FeatureSet:
    """Return the set in a text of either format; `where` names it in errors. Raises UsageError."""
    if (count := text.count("\n")) > MAX_LINES:
        raise UsageError(f"{where} has {count} lines, but a file of settings at most {MAX_LINES}")
    first, _, _ = text.partition("\n")
    if BAGGER_GUID in first:
        raise UsageError(
            f"{where} holds several user sets at once; save a single one with the program that wrote it"
        )
    if BAG_GUID in first:
        lost: list[str] = []
        lines = list(_persistence_lines(text, where, lost))
        if lost and not lines:
            raise UsageError(lost[0])
        found = _from_persistence(lines, _device_of(text), selectors_of, where, lost)
        return replace(found, lost_lines=tuple(lost))
    return _from_yaml(text, where)


def to_persistence(features: FeatureSet) -> str:
    """Return the text of a set in GenICam's persistence format."""
    lines = [
        f"# {BAG_GUID}",
        "# GenApi persistence file (version 3.5.0)",
        f"# Device = {_one_line(features.device)}",
    ]
    selected: dict[str, str] = {}
    for key, value in features.settings.items():
        if "\n" in str(value) or "\r" in str(value):
            continue  # only YAML can express it
        for selector, entry in key.selected:
            if selected.get(selector) != entry:
                lines.append(f"{selector}\t{entry}")
                selected[selector] = entry
        lines.append(f"{key.name}\t{int(value) if isinstance(value, bool) else format_value(value)}")
        if key.name in selected:
            selected[key.name] = format_value(value)
    return "\n".join(lines) + "\n"


def _persistence_lines(text: str, where: str, lost: list[str]) -> Iterator[tuple[str, str]]:
    for number, line in enumerate(text.split("\n"), 1):
        line = line.removesuffix("\r")
        if not line.strip() or line.startswith("#"):
            continue
        name, tab, value = line.partition("\t")
        name = name.rstrip(" ")
        if not tab or not re.fullmatch(_NAME, name, re.ASCII):
            lost.append(f"{where}, line {number}: '{line[:60]}' is not a name, a tabulator and a value")
            continue
        # pylon pads some values; no camera has an entry or a number with blanks at its end.
        yield name, value.rstrip(" ")


def _from_persistence(
    lines: list[tuple[str, str]],
    device: str,
    selectors_of: SelectorsOf | None,
    where: str,
    lost: list[str],
) -> FeatureSet:
    """Return the settings that a camera has after these names and values were written to it.

    Those of a selection that no camera has are added to `lost` instead.
    """
    selectors_of = selectors_of or _guessed_selectors(lines)
    selectors = {selector for name, _ in lines for selector in selectors_of(name)}
    entries: dict[str, str] = {}
    settings: dict[SettingKey, FeatureValue] = {}
    for name, value in lines:
        selected = tuple((s, entries[s]) for s in selectors_of(name) if s in entries)
        if name in selectors:
            entries[name] = value
        elif wrong := next((f"{s}={entry}" for s, entry in selected if not _ENTRY.fullmatch(entry)), ""):
            lost.append(f"{where}: {name} with {wrong[:60]}, which is no entry of a selector")
        else:
            settings[SettingKey(name, selected)] = value
    return FeatureSet(settings, device)


def _guessed_selectors(lines: Iterable[tuple[str, str]]) -> SelectorsOf:
    """Return for each feature the selectors (by their SFNC names) that changed between its lines."""
    entries: dict[str, str] = {}
    first: dict[str, dict[str, str]] = {}
    guessed: dict[str, tuple[str, ...]] = {}
    for name, value in lines:
        if name.endswith("Selector"):
            if name in entries or len(entries) < _MOST_SELECTORS:
                entries[name] = value
            continue
        before = first.setdefault(name, dict(entries))
        changed = tuple(s for s, entry in entries.items() if before.get(s, entry) != entry)
        guessed[name] = tuple(dict.fromkeys((*guessed.get(name, ()), *changed)))
    return lambda name: guessed.get(name, ())


def _device_of(text: str) -> str:
    for line in text.splitlines()[:10]:
        if line.startswith("# Device = "):
            return line.removeprefix("# Device = ").strip()
    return ""


def to_yaml(features: FeatureSet) -> str:
    """Return the text of a set as YAML, with the same meaning in versions 1.1 and 1.2."""
    lines = [f"device: {to_json(features.device)}", "features:"]
    lines += [f"  {key}: {_to_scalar(value)}" for key, value in features.settings.items()]
    if len(lines) == 2:
        lines[1] = "features: {}"
    return "\n".join(lines) + "\n"


def _from_yaml(text: str, where: str) -> FeatureSet:
    settings: dict[SettingKey, FeatureValue] = {}
    lost: list[str] = []
    device, inside = "", False
    for number, line in enumerate(text.split("\n"), 1):
        if not line.strip() or line.lstrip().startswith("#") or line.rstrip() in ("---", "..."):
            continue
        try:
            match = _YAML_LINE.fullmatch(line.rstrip())
            if match is None:
                raise UsageError(f"'{line.strip()[:60]}' is not 'Name: value' of a file of settings")
            indentation, name, rest = match[1], match[2], match[3] or ""
            if not indentation:
                inside = name == "features"
                if name == "device":
                    device = str(_scalar(rest))
                elif inside and (flow := _without_comment(rest)) not in ("", "{}"):
                    raise UsageError(f"'{flow[:60]}' follows 'features:'; write each setting in a line below")
            elif inside:
                settings[SettingKey.parse(name)] = _scalar(rest)
        except UsageError as error:
            lost.append(f"{where}, line {number}: {error}")
    if not re.search(r"^features:", text, re.MULTILINE):
        if name := foreign.format_name(text):
            raise UsageError(
                f"{where} is {name}, which is not read; save the settings in GenICam's format there "
                "(.pfs, .cset), or in a user set of the camera"
            )
        raise UsageError(
            f"{where} is no file of settings: it has neither GenICam's first line nor 'features:'"
        )
    if lost and not settings:
        raise UsageError(lost[0])
    return FeatureSet(settings, device, lost_lines=tuple(lost))


def _to_scalar(value: FeatureValue) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        # YAML 1.1 reads 1e-05 as text: a number needs a point.
        text = repr(value) if math.isfinite(value) else to_json(repr(value))
        return text.replace("e", ".0e") if "e" in text and "." not in text else text
    if _PLAIN.fullmatch(value) and value.lower() not in _YAML_WORDS:
        return value
    return to_json(value, ascii_only=not value.isprintable())


def _scalar(text: str) -> FeatureValue:
    text = text.strip()
    if text.startswith('"'):
        return _quoted(text)
    if text.startswith("'"):
        match = re.match(r"'((?:[^']|'')*)'\s*(#.*)?$", text)
        if match is None:
            raise UsageError("a text that begins with ' has no end")
        return match[1].replace("''", "'")
    text = _without_comment(text)
    if text[:1] in ("[", "{", "|", ">", "&", "*", "!", "%", "@", "`"):
        raise UsageError(f"'{text[:60]}' is not a plain value; put text into quotes")
    if text in ("true", "false"):
        return text == "true"
    if _INTEGER.fullmatch(text):
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text


def _without_comment(text: str) -> str:
    return re.sub(r"(^|\s)#.*$", "", text).strip()


def _quoted(text: str) -> str:
    try:
        value, end = json.JSONDecoder().raw_decode(text)
    except ValueError:
        raise UsageError("the text in quotes has no end, or a \\ that says nothing") from None
    rest = text[end:].strip()
    if rest and not rest.startswith("#"):
        raise UsageError(f"'{rest[:60]}' behind the text in quotes")
    return str(value)


def _one_line(text: str) -> str:
    return " ".join(text.split())
