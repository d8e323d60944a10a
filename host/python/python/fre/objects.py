"""Objects to grasp, world frame: that is the finger frame at a motor angle of 0."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, Union

Pair = tuple[float, float]


class _Object:
    """An object; its fields are the keys of ``[object]``."""

    shape: ClassVar[str]

    def to_dict(self) -> dict[str, Any]:
        """The table ``[object]`` of a case file."""
        return {"shape": self.shape, **_plain(dataclasses.asdict(self))}  # type: ignore[call-overload]


def _plain(table: dict[str, Any]) -> dict[str, Any]:
    return {key: _value(value) for key, value in table.items()}


def _value(value: Any) -> Any:
    if isinstance(value, (str, bool)):
        return value
    if hasattr(value, "__iter__"):
        return [_value(entry) for entry in value]
    return float(value)


@dataclasses.dataclass(frozen=True)
class Circle(_Object):
    """A circular cylinder."""

    shape: ClassVar[str] = "circle"
    radius_mm: float
    centre_mm: Pair
    friction: float = 0.0


@dataclasses.dataclass(frozen=True)
class Ellipse(_Object):
    """An elliptic cylinder; ``angle_deg`` turns its first semi-axis from x, counter-clockwise."""

    shape: ClassVar[str] = "ellipse"
    centre_mm: Pair
    semi_axes_mm: Pair
    angle_deg: float = 0.0
    friction: float = 0.0


@dataclasses.dataclass(frozen=True)
class Polygon(_Object):
    """A convex prism with rounded edges: all points within ``rounding_mm`` of a polygon with these corners."""

    shape: ClassVar[str] = "polygon"
    corners_mm: tuple[Pair, ...]
    rounding_mm: float
    friction: float = 0.0


@dataclasses.dataclass(frozen=True)
class HalfPlane(_Object):
    """A wall or a floor: a point of its surface, and the direction out of it."""

    shape: ClassVar[str] = "half-plane"
    point_mm: Pair
    normal: Pair
    friction: float = 0.0


@dataclasses.dataclass(frozen=True)
class Bore(_Object):
    """A cylindrical hole with the finger in it."""

    shape: ClassVar[str] = "bore"
    radius_mm: float
    centre_mm: Pair
    friction: float = 0.0


Object = Union[Circle, Ellipse, Polygon, HalfPlane, Bore]
SHAPES: dict[str, type[Object]] = {kind.shape: kind for kind in (Circle, Ellipse, Polygon, HalfPlane, Bore)}


def read(table: dict[str, Any]) -> Object:
    """The object of a table ``[object]`` that a case has accepted."""
    fields = {key: frozen(value) for key, value in table.items() if key != "shape"}
    return SHAPES[table["shape"]](**fields)


def frozen(value: Any) -> Any:
    """A value of a table that has a hash: lists are tuples, and tables sets of keys with their values."""
    if isinstance(value, dict):
        return frozenset((key, frozen(entry)) for key, entry in value.items())
    return tuple(frozen(entry) for entry in value) if isinstance(value, list) else value
