"""The microcontroller's estimator on this PC: single precision, its sizes, its discretisation."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from . import _core
from .case import Case, CaseLike
from .status import STATUSES, Status


class Estimate(NamedTuple):
    """What the estimator says at one tick; the numbers are single-precision ones."""

    status: Status
    """Whether the numbers below may be used."""
    motor_angle_rad: float
    """Motor angle the estimate was asked for."""
    force_x_n: float
    """Force on the object, world frame."""
    force_y_n: float
    force_magnitude_n: float
    contact_x_mm: float
    """Centre of the contact, world frame; 0 without contact."""
    contact_y_mm: float
    contact_extent_mm: float
    """Arc length of the front beam between the outermost touching samples."""
    torque_nmm: float
    """Torque the contact demands of the motor, positive when it must push to close."""
    distance_mm: float
    """Smallest distance between finger and object; slightly negative when touching."""
    residual_nmm: float
    """Largest gradient component left."""
    force_x_per_rad_n: float
    """Derivative of the force with respect to the motor angle."""
    force_y_per_rad_n: float
    standard_deviation_n: float
    """Standard deviation of the force's magnitude."""
    iterations: int
    """Newton iterations spent in this tick."""
    age: int
    """Ticks since the last trustworthy estimate; 0 for a trustworthy one."""
    sensitivity_age: int
    """Ticks since the derivatives were taken."""
    force_interval_n: tuple[float, float] | None
    """Between which values the force's magnitude lies, with friction, and with memory while the past is not known. None without both, and
    while an end is not known."""
    normal_interval_n: tuple[float, float] | None
    """The same for the sum of the normal forces."""
    torque_interval_nmm: tuple[float, float] | None
    """The same for the torque."""
    loaded_rib: int
    """The rib that is near its buckling load, from 1 at the base; 0 if none is."""
    rib_load_percent: int
    """Its force in percent of that load; 0 if none is."""


class Estimator:
    """Motor angle in, contact force out, once per tick of a control loop: the numbers of the microcontroller, bit for bit, and its
    room: up to 16 lamellae or ribs. (The NUCLEO-G474RE has less.)

    A pickled estimator begins anew where it is unpickled: its history stays behind.
    """

    __slots__ = ("_case", "_estimator", "_physics")

    def __init__(self, case: CaseLike, physics: Literal["paper", "extended"] = "extended") -> None:
        """An estimator of a case's finger on its object; the case's places do not matter."""
        self._case = Case.of(case)
        self._physics: Literal["paper", "extended"] = physics
        self._estimator = _core.Estimator(self._case._case, physics)

    @property
    def case(self) -> Case:
        """Finger and object."""
        return self._case

    def update(self, angle_rad: float, dt_s: float = 0.0) -> Estimate:
        """The estimate at a motor angle, ``dt_s`` after the one before. Elastic fingers do not depend on the time; the
        force of one whose material has memory fades, and is known within an interval only if the first angle is one in contact.

        With friction it depends on the angles before: after a leap of more than 1° the force is known within an interval only, until a
        motion makes it certain.
        """
        word, numbers, counts, ends, loaded = self._estimator.update(angle_rad, dt_s)
        return Estimate._make([STATUSES[word], *numbers, *counts, *ends, *loaded])

    def __repr__(self) -> str:
        return f"<fre.Estimator of {self._case!r}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Estimator, (self._case, self._physics)
