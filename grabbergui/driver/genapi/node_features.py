"""Nodes to features and back.

One odd node must not spoil the others: whatever GenApi raises while a node is read ends in the feature's
`problem`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from genicam import genapi

from grabbergui.core.features import (
    AccessMode,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    Representation,
    Visibility,
)
from grabbergui.core.sfnc import role_of

_KINDS = {
    genapi.EInterfaceType.intfIInteger: FeatureKind.INTEGER,
    genapi.EInterfaceType.intfIFloat: FeatureKind.FLOAT,
    genapi.EInterfaceType.intfIBoolean: FeatureKind.BOOLEAN,
    genapi.EInterfaceType.intfIEnumeration: FeatureKind.ENUMERATION,
    genapi.EInterfaceType.intfICommand: FeatureKind.COMMAND,
    genapi.EInterfaceType.intfIString: FeatureKind.STRING,
}

_ACCESS = {
    genapi.EAccessMode.NI: AccessMode.NOT_IMPLEMENTED,
    genapi.EAccessMode.NA: AccessMode.NOT_AVAILABLE,
    genapi.EAccessMode.WO: AccessMode.WRITE_ONLY,
    genapi.EAccessMode.RO: AccessMode.READ_ONLY,
    genapi.EAccessMode.RW: AccessMode.READ_WRITE,
}

_REPRESENTATIONS = {
    genapi.ERepresentation.Linear: Representation.LINEAR,
    genapi.ERepresentation.Logarithmic: Representation.LOGARITHMIC,
    genapi.ERepresentation.Boolean: Representation.BOOLEAN,
    genapi.ERepresentation.PureNumber: Representation.PURE_NUMBER,
    genapi.ERepresentation.HexNumber: Representation.HEX_NUMBER,
    genapi.ERepresentation.IPV4Address: Representation.IPV4_ADDRESS,
    genapi.ERepresentation.MACAddress: Representation.MAC_ADDRESS,
}

_INT64_MAX = 2**63 - 1

_WHERE_THROWN = re.compile(r"\s*: \w+Exception thrown\b.*", re.DOTALL)
_ALARM = re.compile(r"(?:(?:Fatal error|ERROR|WARNING) ?:|SWIG director method error\.)\s*")
"""What stands before and behind what GenApi has to say."""


def _representation(value: Any, *, of_quantity: bool) -> Representation:
    """PureNumber is also what GenApi says where the description says nothing: a quantity gets its slider."""
    known = _REPRESENTATIONS.get(value.representation, Representation.LINEAR)
    return Representation.LINEAR if of_quantity and known is Representation.PURE_NUMBER else known


def is_category(value: Any) -> bool:
    """Whether a node is a branch of the feature tree."""
    return bool(value.node.principal_interface_type == genapi.EInterfaceType.intfICategory)


def describe(node: Any, category: str) -> FeatureDescription | None:
    """What never changes about a node; None for kinds that people cannot use (raw registers, ports)."""
    kind = _KINDS.get(node.principal_interface_type)
    if kind is None:
        return None
    return FeatureDescription(
        name=node.name,
        kind=kind,
        display_name=node.display_name,
        tooltip=node.tooltip,
        description=node.description,
        visibility=visibility_of(node),
        category=category,
        streamable=node.is_streamable(),
        selectors=tuple(selector.node.name for selector in node.selecting_features),
    )


def visibility_of(node: Any) -> Visibility:
    """A node's visibility."""
    return Visibility(min(max(int(node.visibility), 0), 3))


def access_of(value: Any) -> AccessMode:
    """A node's access mode just now; may read registers."""
    return _ACCESS.get(value.get_access_mode(), AccessMode.NOT_AVAILABLE)


def snapshot(value: Any, description: FeatureDescription, auto: str | None) -> Feature:
    """The node as it is now; may read registers unless they are cached. Never raises GenApi's errors."""
    known: dict[str, Any] = {**vars(description), "auto": auto, "access": AccessMode.NOT_AVAILABLE}
    try:
        known["access"] = access_of(value)
        if known["access"] in (AccessMode.NOT_IMPLEMENTED, AccessMode.NOT_AVAILABLE):
            return Feature(**known)
        known.update(_READERS[description.kind](value))
        if known["access"].readable and description.kind is not FeatureKind.COMMAND:
            known["value"] = _standing(value, description.kind, known["access"])
        return Feature(**known)
    # SWIG lets through what C++ threw and what our port raised; both make this one row unusable.
    except (genapi.GenericException, RuntimeError, ValueError, OverflowError) as error:
        return Feature(**{**known, "access": AccessMode.NOT_AVAILABLE, "problem": reason_of(error)})


def assign(value: Any, kind: FeatureKind, new: FeatureValue) -> None:
    """Write a validated value to a node. Raises GenApi's exceptions."""
    if kind is FeatureKind.ENUMERATION:
        value.from_string(str(new))
    else:
        value.set_value(new)


def reason_of(error: BaseException) -> str:
    """What GenApi says without where in its sources it says it."""
    text = _WHERE_THROWN.sub("", _ALARM.sub("", str(error), count=1))
    return " ".join(text.replace(" : ", ": ").split()).rstrip(".")


def read_value(value: Any, kind: FeatureKind) -> FeatureValue:
    """A readable node's value. Raises GenApi's exceptions."""
    if kind is FeatureKind.INTEGER:
        return int(value.value)
    if kind is FeatureKind.FLOAT:
        return float(value.value)
    if kind is FeatureKind.BOOLEAN:
        return bool(value.value)
    return str(value.to_string()) if kind is FeatureKind.ENUMERATION else str(value.value)


def _standing(value: Any, kind: FeatureKind, access: AccessMode) -> FeatureValue | None:
    """What a readable node holds; None where that means nothing and something else can be written.

    So does the number of no entry, or text that is no UTF-8. What our port raises is no GenericException.
    """
    try:
        return read_value(value, kind)
    except (genapi.GenericException, UnicodeDecodeError):
        if access.writable:
            return None
        raise


def _limits(low: int | float, high: int | float) -> dict[str, Any]:
    """Both limits; none that is no number, and neither where they exclude everything."""
    if low > high:
        return {}
    return {name: limit for name, limit in (("minimum", low), ("maximum", high)) if math.isfinite(limit)}


def _increment(increment: int | float) -> int | float | None:
    return increment if increment > 0 else None


def _integer(value: Any) -> dict[str, Any]:
    return {
        **_limits(int(value.min), int(value.max)),
        "increment": _increment(int(value.inc)),
        "unit": value.unit,
        "representation": _representation(value, of_quantity=role_of(value.node.name) is not None),
    }


def _float(value: Any) -> dict[str, Any]:
    return {
        **_limits(float(value.min), float(value.max)),
        "increment": _increment(float(value.inc)) if value.has_inc() else None,
        "unit": value.unit,
        "representation": _representation(value, of_quantity=True),
    }


def _enumeration(value: Any) -> dict[str, Any]:
    entries = []
    for entry in value.entries:
        access = access_of(entry)
        if access is not AccessMode.NOT_IMPLEMENTED:
            node = entry.node
            # GenApi falls back to the node's name, EnumEntry_PixelFormat_Mono8, which is for no eye.
            display = "" if node.display_name == node.name else node.display_name
            available = access is not AccessMode.NOT_AVAILABLE
            entries.append(EnumEntry(entry.symbolic, display, node.tooltip, available))
    return {"entries": tuple(entries)}


def _string(value: Any) -> dict[str, Any]:
    length = int(value.max_length)
    return {"maximum_length": length if 0 < length < _INT64_MAX else None}


_READERS: dict[FeatureKind, Callable[[Any], dict[str, Any]]] = {
    FeatureKind.INTEGER: _integer,
    FeatureKind.FLOAT: _float,
    FeatureKind.BOOLEAN: lambda value: {},
    FeatureKind.ENUMERATION: _enumeration,
    FeatureKind.COMMAND: lambda value: {},
    FeatureKind.STRING: _string,
}
