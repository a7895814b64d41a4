"""A set of frames as one frame, with a component for each camera, for all that takes frames."""

from __future__ import annotations

from copy import copy
from dataclasses import fields, replace

from typing_extensions import override

from grabbergui.core.component import Component, PayloadType, own_component
from grabbergui.core.frame import Frame, FrameStatus, time_of_day
from grabbergui.core.json_text import to_json
from grabbergui.rig.frame_sets import FrameSet


class SetFrame(Frame):
    """A frame made of the frames of several cameras. Its own image is that of the first one present."""

    images: FrameSet[Frame]
    "The frames by the names of their cameras."

    @classmethod
    def of(cls, images: FrameSet[Frame]) -> SetFrame:
        """Return the frame of a set, whose times are on the monotonic clock."""
        parts: list[Component] = []
        for source, name in enumerate(images.cameras):
            if (frame := images.get(name)) is not None:
                parts += [replace(part, source=source, camera=name) for part in frame.components]
        own = own_component(parts)
        first = next(iter(images.values()), None)
        values = {item.name: getattr(first, item.name) for item in fields(Frame)} if first is not None else {}
        if own is not None:
            values |= {
                name: getattr(own, name)
                for name in ("payload", "width", "height", "pixel_format", "offset_x", "offset_y")
            }
            values |= {
                "padding_x": own.padding_x,
                "big_endian": own.big_endian,
                "_conversions": own._conversions,
            }
        values |= {
            "frame_id": images.index,
            "received_ns": time_of_day(images.time_ns),
            "captured": images.time_ns / 1e9,
            "status": FrameStatus.INCOMPLETE if images.missing else FrameStatus.COMPLETE,
            "missing_bytes": sum(frame.missing_bytes for frame in images.values()),
            "parts": tuple(parts),
            "payload_type": PayloadType.MULTI_PART,
            "chunk_payload": None,
        }
        made = cls(**values)
        made.images = images
        return made

    @override
    def members(self) -> dict[str, Frame]:
        """Return the frames by camera, with the set's time, so that all of a set have equal stamps."""
        return {
            name: replace(frame, received_ns=self.received_ns, captured=self.captured)
            for name, frame in self.images.items()
        }

    @override
    def set_description(self) -> str:
        images = self.images
        return to_json(
            {
                "index": images.index,
                "state": images.state.value,
                "cameras": list(images.cameras),
                "offsets_ns": {name: stamp.time_ns - images.time_ns for name, stamp in images.stamps.items()},
                "frame_ids": {name: each.frame_id for name, each in images.items()},
                "missing": list(images.missing),
            }
        )

    @override
    def detached(self) -> Frame:
        images = copy(self.images)
        for name, frame in self.images.items():
            images[name] = frame.detached()
        made = SetFrame.of(images)
        made.received_ns, made.captured = self.received_ns, self.captured
        return made
