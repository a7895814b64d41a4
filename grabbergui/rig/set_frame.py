"""A set of frames as one frame, with a component for each camera, for all that takes frames."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from grabbergui.core.component import Component, ComponentKind, PayloadType, own_component
from grabbergui.core.frame import Frame, FrameStatus, time_of_day
from grabbergui.rig.frame_sets import FrameSet


@dataclass(frozen=True, eq=False)
class CameraImage(Component):
    """An image of one camera of a rig."""

    camera: str = ""
    "The camera's name in the rig."

    @property
    def name(self) -> str:
        """The camera's name, and the kind if it is another than the intensity."""
        if self.kind is ComponentKind.INTENSITY:
            return self.camera
        return f"{self.camera}_{self.kind.name.lower()}"


class SetFrame(Frame):
    """A frame made of the frames of several cameras. Its own image is that of the first one present."""

    images: FrameSet[Frame]
    "The frames by the names of their cameras."

    @classmethod
    def of(cls, images: FrameSet[Frame], cameras: tuple[str, ...]) -> SetFrame:
        """Return the frame of a set, whose times are on the monotonic clock; `cameras` in the rig's order."""
        parts: list[Component] = []
        for source, name in enumerate(cameras):
            if (frame := images.get(name)) is not None:
                parts += [_of_camera(component, name, source) for component in frame.components]
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

    def stamped(self, name: str) -> Frame | None:
        """Return the frame of a camera with the set's time, so that all of a set have equal stamps."""
        frame = self.images.get(name)
        if frame is None:
            return None
        return replace(frame, received_ns=self.received_ns, captured=self.captured)


def _of_camera(component: Component, camera: str, source: int) -> CameraImage:
    values = {item.name: getattr(component, item.name) for item in fields(Component)}
    return CameraImage(**{**values, "source": source}, camera=camera)
