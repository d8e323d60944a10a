"""Motions: how the finger's base moves, and where along it results are wanted."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any, Union


@dataclasses.dataclass(frozen=True)
class Rotation:
    """A motor turns the finger about its axis; positive angles close it."""

    motor_angles_deg: tuple[float, ...]
    """Motor angles in the order in which they are passed."""

    def __init__(self, motor_angles_deg: Iterable[float]) -> None:
        object.__setattr__(self, "motor_angles_deg", tuple(float(angle) for angle in motor_angles_deg))

    def to_dict(self) -> dict[str, Any]:
        """The table ``[motion]`` of a case file."""
        return {"motor_angles_deg": list(self.motor_angles_deg)}


@dataclasses.dataclass(frozen=True)
class Translation:
    """A parallel gripper moves the base along a line."""

    direction: tuple[float, float]
    """Direction; its length does not matter."""
    distances_mm: tuple[float, ...]
    """Distances in the order in which they are passed."""

    def __init__(self, direction: tuple[float, float], distances_mm: Iterable[float]) -> None:
        object.__setattr__(self, "direction", (float(direction[0]), float(direction[1])))
        object.__setattr__(self, "distances_mm", tuple(float(distance) for distance in distances_mm))

    def to_dict(self) -> dict[str, Any]:
        """The table ``[motion]`` of a case file."""
        return {"direction": list(self.direction), "distances_mm": list(self.distances_mm)}


Motion = Union[Rotation, Translation]


def read(table: dict[str, Any]) -> Motion:
    """The motion of a table ``[motion]`` that a case has accepted."""
    if "motor_angles_deg" in table:
        return Rotation(table["motor_angles_deg"])
    return Translation(tuple(table["direction"]), table["distances_mm"])
