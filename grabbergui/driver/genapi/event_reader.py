"""Reads the features that a device event carries, by GenApi's event adapters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from genicam import genapi

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.features import Feature
from grabbergui.core.grabber import DeviceEvent
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi import node_features

EVENT_SELECTOR = "EventSelector"

_EVENT_ADAPTER = {
    DataLayout.GIGE_VISION: genapi.EventAdapterGEV,
    DataLayout.USB3_VISION: genapi.EventAdapterU3V,
}


class EventReader:
    """The event adapter of one node map. Calls are serialised by the map's owner."""

    def __init__(self, node_map: Any, layout: DataLayout) -> None:
        self._adapter = _EVENT_ADAPTER[layout](node_map.pointer)
        self._names = _event_names(node_map)

    def deliver(self, message: bytes) -> None:
        """Update the event's nodes from a message. Raises RemoteProtocolError."""
        try:
            self._adapter.deliver_message(message)
        except (genapi.GenericException, RuntimeError) as error:
            raise RemoteProtocolError(f"event message: {node_features.reason_of(error)}") from error

    def event(self, event_id: int, changed: Mapping[str, Feature]) -> DeviceEvent:
        """Return the event whose message changed these nodes."""
        values = {name: feature.value for name, feature in changed.items() if feature.value is not None}
        return DeviceEvent(self._name_of(changed) or f"0x{event_id:04X}", event_id, values)

    def close(self) -> None:
        """Release the node map."""
        self._adapter.detach_node_map()

    def _name_of(self, changed: Mapping[str, Feature]) -> str:
        # SFNC: the features of event X are called EventX, EventXTimestamp, EventXFrameID …
        fitting = [name for name in self._names if any(node.startswith(f"Event{name}") for node in changed)]
        return max(fitting, key=len, default="")


def _event_names(node_map: Any) -> list[str]:
    if not node_map.has_node(EVENT_SELECTOR):
        return []
    selector = node_map.get_node(EVENT_SELECTOR)
    return [entry.symbolic for entry in selector.entries] if hasattr(selector, "entries") else []
