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
    times_s: tuple[float, ...] | None = None
    """Time at each angle, increasing; the same angle at a later time is a hold. It matters to a material with memory."""
    speed_deg_per_s: float | None = None
    """Speed of the motor, in place of the times."""

    def __init__(
        self,
        motor_angles_deg: Iterable[float],
        times_s: Iterable[float] | None = None,
        speed_deg_per_s: float | None = None,
    ) -> None:
        object.__setattr__(self, "motor_angles_deg", tuple(float(angle) for angle in motor_angles_deg))
        object.__setattr__(self, "times_s", _times(times_s))
        object.__setattr__(self, "speed_deg_per_s", None if speed_deg_per_s is None else float(speed_deg_per_s))

    def to_dict(self) -> dict[str, Any]:
        """The table ``[motion]`` of a case file."""
        table: dict[str, Any] = {"motor_angles_deg": list(self.motor_angles_deg)}
        if self.times_s is not None:
            table["times_s"] = list(self.times_s)
        if self.speed_deg_per_s is not None:
            table["speed_deg_per_s"] = self.speed_deg_per_s
        return table


@dataclasses.dataclass(frozen=True)
class Translation:
    """A parallel gripper moves the base along a line."""

    direction: tuple[float, float]
    """Direction; its length does not matter."""
    distances_mm: tuple[float, ...]
    """Distances in the order in which they are passed."""
    times_s: tuple[float, ...] | None = None
    """Time at each distance, increasing; the same distance at a later time is a hold."""

    def __init__(
        self,
        direction: tuple[float, float],
        distances_mm: Iterable[float],
        times_s: Iterable[float] | None = None,
    ) -> None:
        object.__setattr__(self, "direction", (float(direction[0]), float(direction[1])))
        object.__setattr__(self, "distances_mm", tuple(float(distance) for distance in distances_mm))
        object.__setattr__(self, "times_s", _times(times_s))

    def to_dict(self) -> dict[str, Any]:
        """The table ``[motion]`` of a case file."""
        table: dict[str, Any] = {"direction": list(self.direction), "distances_mm": list(self.distances_mm)}
        if self.times_s is not None:
            table["times_s"] = list(self.times_s)
        return table


Motion = Union[Rotation, Translation]


def _times(times_s: Iterable[float] | None) -> tuple[float, ...] | None:
    return None if times_s is None else tuple(float(time) for time in times_s)


def read(table: dict[str, Any]) -> Motion:
    """The motion of a table ``[motion]`` that a case has accepted."""
    if "motor_angles_deg" in table:
        return Rotation(table["motor_angles_deg"], table.get("times_s"), table.get("speed_deg_per_s"))
    return Translation(tuple(table["direction"]), table["distances_mm"], table.get("times_s"))
