"""What a designer asks of a finger, as numbers of a solution: goals and limits of :mod:`fre.optimisation`.

A measure says at which places a case must be solved, reads its number, and, where the solver's own derivatives are enough, the exact
derivatives of that number.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .case import Case
from .motion import Rotation
from .solution import Place, Solution

Array = NDArray[np.float64]
Derivative = Callable[[Place, str], "Array | None"]
"""Derivative of the force at a place with a key's value, [x, y], N per the key's unit; None where the solver gives none."""


class Unreached(Exception):
    """The measure has no number: a place that it needs has no trustworthy solution."""


class Measure(Protocol):
    """A number of a finger."""

    @property
    def unit(self) -> str:
        """Its unit."""

    def places(self) -> list[float]:
        """Motor angles (degrees) or distances (mm) at which the case must be solved."""

    def value(self, solution: Solution) -> float:
        """The number; raises :class:`Unreached` if there is none."""

    def slope(self, solution: Solution, key: str) -> float | None:
        """Its exact derivative with a key's value; None where there is none."""


def places_of(solution: Solution, wanted: Sequence[float]) -> list[Place]:
    """The places that a measure has asked for."""
    at = {float(where): index for index, where in enumerate(solution.places)}
    found = [solution[at[float(where)]] for where in wanted]
    for place in found:
        if not place.status.is_trustworthy:
            raise Unreached(f"{place!r}")
    return found


def force_slope(case: Case, place: Place, key: str) -> Array | None:
    """Derivative of the force with a key's value, from the solver's sensitivities: [x, y], N per the key's unit."""
    found = place.sensitivity
    if found is None:
        return None
    if key == "finger.material.youngs_modulus_pa":
        # The force is proportional to the modulus: the contact's softness is the front beam's own, 1/(E·width).
        return np.asarray(place.force_n / case.finger["material.youngs_modulus_pa"])
    names = {
        "finger.front.thickness_mm": "force_per_front_thickness_mm_n",
        "finger.back.thickness_mm": "force_per_back_thickness_mm_n",
        "finger.hinge.thickness_mm": "force_per_hinge_thickness_mm_n",
        "finger.hinge.length_mm": "force_per_hinge_length_mm_n",
        "object.radius_mm": "force_per_radius_mm_n",
    }
    if key in names:
        slope = found[names[key]]
        return None if slope is None else np.asarray(slope)
    for start, name in (("finger.motor.axis_mm.", "force_per_motor_axis_mm_n"), ("object.centre_mm.", "force_per_centre_mm_n")):
        if key.startswith(start):
            return np.asarray(found[name][int(key.removeprefix(start))])
    return None


def _magnitude_slope(case: Case, place: Place, key: str) -> float | None:
    slope = force_slope(case, place, key)
    if slope is None:
        return None
    size = place.force_magnitude_n
    return float(slope @ place.force_n / size) if size > 0.0 else 0.0


@dataclasses.dataclass(frozen=True)
class Force:
    """Magnitude of the contact force at a place, N."""

    at: float
    unit: str = dataclasses.field(default="N", init=False, repr=False)

    def places(self) -> list[float]:
        return [self.at]

    def value(self, solution: Solution) -> float:
        return places_of(solution, self.places())[0].force_magnitude_n

    def slope(self, solution: Solution, key: str) -> float | None:
        return _magnitude_slope(solution.case, places_of(solution, self.places())[0], key)


def _span(first: float, last: float, count: int) -> list[float]:
    return [float(value) for value in np.linspace(first, last, count)]


@dataclasses.dataclass(frozen=True)
class MeanForce:
    """Mean magnitude of the contact force over a range, N."""

    first: float
    last: float
    count: int = 13
    unit: str = dataclasses.field(default="N", init=False, repr=False)

    def places(self) -> list[float]:
        return _span(self.first, self.last, self.count)

    def value(self, solution: Solution) -> float:
        return float(np.mean([place.force_magnitude_n for place in places_of(solution, self.places())]))

    def slope(self, solution: Solution, key: str) -> float | None:
        slopes = [_magnitude_slope(solution.case, place, key) for place in places_of(solution, self.places())]
        known = [slope for slope in slopes if slope is not None]
        return float(np.mean(known)) if len(known) == len(slopes) else None


@dataclasses.dataclass(frozen=True)
class ForceVariation:
    """How far the force is from constant over a range: (max − min)/mean."""

    first: float
    last: float
    count: int = 13
    unit: str = dataclasses.field(default="", init=False, repr=False)

    def places(self) -> list[float]:
        return _span(self.first, self.last, self.count)

    def value(self, solution: Solution) -> float:
        forces = np.array([place.force_magnitude_n for place in places_of(solution, self.places())])
        mean = float(forces.mean())
        if mean <= 0.0:
            raise Unreached("no contact over the whole range")
        return float(forces.max() - forces.min()) / mean

    def slope(self, solution: Solution, key: str) -> float | None:
        places = places_of(solution, self.places())
        forces = np.array([place.force_magnitude_n for place in places])
        slopes = [_magnitude_slope(solution.case, place, key) for place in places]
        known = np.array([slope for slope in slopes if slope is not None])
        if len(known) < len(slopes):
            return None
        most, least, mean = int(forces.argmax()), int(forces.argmin()), float(forces.mean())
        spread = float(forces[most] - forces[least])
        return float((known[most] - known[least]) / mean - spread * known.mean() / mean**2)


@dataclasses.dataclass(frozen=True)
class Stiffness:
    """Stiffness that the object meets along the contact force at a place, N/mm: what its force grows by per mm that it is pushed
    against it."""

    at: float
    unit: str = dataclasses.field(default="N/mm", init=False, repr=False)

    def places(self) -> list[float]:
        return [self.at]

    def value(self, solution: Solution) -> float:
        place = places_of(solution, self.places())[0]
        if place.sensitivity is None or place.force_magnitude_n <= 0.0:
            raise Unreached(f"{place!r}: no contact, or no derivatives")
        along = place.force_n / place.force_magnitude_n
        return float(-(along @ place.sensitivity["stiffness_n_per_mm"] @ along))

    def slope(self, solution: Solution, key: str) -> float | None:
        return None


@dataclasses.dataclass(frozen=True)
class ContactLength:
    """Arc of the front beam between the outermost touching points at a place, mm: how far the finger wraps around the object."""

    at: float
    unit: str = dataclasses.field(default="mm", init=False, repr=False)

    def places(self) -> list[float]:
        return [self.at]

    def value(self, solution: Solution) -> float:
        contacts = places_of(solution, self.places())[0].contacts
        return float(contacts[-1].arc_mm - contacts[0].arc_mm) if contacts else 0.0

    def slope(self, solution: Solution, key: str) -> float | None:
        return None


@dataclasses.dataclass(frozen=True)
class Conformity:
    """How far the contact force is spread along the front beam at a place, mm: the length of an evenly loaded arc with the same
    spread, √12 σ. Where :class:`ContactLength` steps from sample to sample, this changes smoothly, so that a search can follow it."""

    at: float
    unit: str = dataclasses.field(default="mm", init=False, repr=False)

    def places(self) -> list[float]:
        return [self.at]

    def value(self, solution: Solution) -> float:
        contacts = places_of(solution, self.places())[0].contacts
        arcs = np.array([contact.arc_mm for contact in contacts])
        forces = np.array([contact.force_n for contact in contacts])
        if forces.sum() <= 0.0:
            return 0.0
        mean = float(np.average(arcs, weights=forces))
        return float(np.sqrt(12.0 * np.average((arcs - mean) ** 2, weights=forces)))

    def slope(self, solution: Solution, key: str) -> float | None:
        return None


@dataclasses.dataclass(frozen=True)
class MaxStrain:
    """Largest strain of beams and hinges up to a place, a share: 0.1 is 10 %."""

    at: float
    unit: str = dataclasses.field(default="", init=False, repr=False)

    def places(self) -> list[float]:
        return [self.at]

    def value(self, solution: Solution) -> float:
        places_of(solution, self.places())
        known = [place for place in solution if place.max_strain is not None]
        strains = [place.to_dict()["max_strain"] for place in known if where(place) <= self.at]
        return float(max(max(strain.values()) for strain in strains))

    def slope(self, solution: Solution, key: str) -> float | None:
        return None


@dataclasses.dataclass(frozen=True)
class Snap:
    """The place before which the finger does not snap through; ``up_to`` if it does not before that."""

    up_to: float
    unit: str = dataclasses.field(default="°", init=False, repr=False)

    def places(self) -> list[float]:
        return [self.up_to]

    def value(self, solution: Solution) -> float:
        for place in solution:
            if not place.status.is_trustworthy or (place.branch or 1) > 1:
                first = place.first_branch
                between = None if first is None else first.to_dict().get("snap_between_deg") or first.to_dict().get("snap_between_mm")
                return float(between[0]) if between else min(where(place), self.up_to)
        return self.up_to

    def slope(self, solution: Solution, key: str) -> float | None:
        return None


@dataclasses.dataclass(frozen=True)
class Mass:
    """Mass of the finger, g: beams and lamellae as they are drawn, roots and tip left aside."""

    density_kg_per_m3: float = 1200.0
    unit: str = dataclasses.field(default="g", init=False, repr=False)

    def places(self) -> list[float]:
        return []

    def value(self, solution: Solution) -> float:
        finger = solution.case.finger.to_dict()
        width = _mean(finger["width_mm"])
        area = 0.0
        ends = {}
        for name in ("front", "back"):
            beam = finger[name]
            base, tip = np.asarray(beam["base_mm"], float), np.asarray(beam["tip_mm"], float)
            ends[name] = (base, tip)
            area += float(np.hypot(*(tip - base))) * _mean(beam["thickness_mm"])
        lamellae = finger.get("lamellae") or {}
        for height in lamellae.get("heights_mm", []):
            across = [base + (tip - base) * (height - base[1]) / (tip[1] - base[1]) for base, tip in ends.values()]
            area += float(np.hypot(*(across[0] - across[1]))) * float(lamellae["thickness_mm"])
        # mm³ times kg/m³ is 1e-6 g.
        return area * width * self.density_kg_per_m3 * 1e-6

    def slope(self, solution: Solution, key: str) -> float | None:
        return None


def _mean(value: Any) -> float:
    """A number, or the mean of a taper over its knots' range."""
    if isinstance(value, (int, float)):
        return float(value)
    at, values = np.array(value, dtype=float).T
    middle = 0.5 * (values[1:] + values[:-1])
    return float(np.sum(middle * np.diff(at)) / (at[-1] - at[0])) if len(at) > 1 else float(values[0])


def where(place: Place) -> float:
    """Motor angle or distance of a place."""
    return place.motor_angle_deg if place.motor_angle_deg == place.motor_angle_deg else place.distance_mm


def closing(measures: Sequence[Measure], case: Case) -> Case:
    """The case with a motion that closes through all places that measures need."""
    wanted = sorted({0.0} | {place for measure in measures for place in measure.places()})
    motion = case.motion
    if isinstance(motion, Rotation):
        return case.with_motion(Rotation(wanted))
    return case.with_motion(dataclasses.replace(motion)) if not wanted else case.with_motion(
        type(motion)(motion.direction, wanted)
    )
