"""What a designer asks of a finger, as numbers: goals and limits of :mod:`fre.optimisation`.

>>> import fre
>>> from fre import measures
>>> case = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([6.0]))
>>> round(measures.Force(at=6.0).value(case), 2)
2.87

Places are motor angles in degrees, or distances in mm of a parallel gripper; a finger closes from 0 to them. The words of a measure are
those of the command ``fre optimise``.
"""

from __future__ import annotations

import abc
import dataclasses

from . import _core
from .case import Case, CaseLike
from .error import case_error
from .options import DEFAULT, Options


class Unreached(Exception):
    """The measure has no number: a place that it needs has no trustworthy solution, or no contact where there must be one."""


class Measure(abc.ABC):
    """A number of a finger."""

    @property
    @abc.abstractmethod
    def words(self) -> str:
        """The measure as ``fre optimise`` reads it."""

    def value(self, case: CaseLike, options: Options = DEFAULT) -> float:
        """The number of a case, whose own places do not matter; raises :class:`Unreached` if there is none."""
        found, _ = _core.measure(Case.of(case)._case, self.words, options)
        if found is None:
            raise Unreached(f"{self.words}: a place has no trustworthy solution or no contact")
        return found


@dataclasses.dataclass(frozen=True)
class Force(Measure):
    """Magnitude of the contact force at a place, N."""

    at: float

    @property
    def words(self) -> str:
        return f"force at {float(self.at)!r}"


def _over(first: float, last: float, count: int) -> str:
    if not 2 <= count <= 1000:
        raise case_error(f"count = {count}: allowed is 2 to 1000", "count")
    if not first < last:
        raise case_error(f"last = {last}: allowed is more than first, {first}", "last")
    return f"over {float(first)!r}:{float(last)!r}:{(last - first) / (count - 1)!r}"


@dataclasses.dataclass(frozen=True)
class MeanForce(Measure):
    """Mean magnitude of the contact force over a range, N."""

    first: float
    last: float
    count: int = 13

    @property
    def words(self) -> str:
        return f"mean-force {_over(self.first, self.last, self.count)}"


@dataclasses.dataclass(frozen=True)
class ForceVariation(Measure):
    """How far the force is from constant over a range: (max − min)/mean."""

    first: float
    last: float
    count: int = 13

    @property
    def words(self) -> str:
        return f"force-variation {_over(self.first, self.last, self.count)}"


@dataclasses.dataclass(frozen=True)
class Stiffness(Measure):
    """Stiffness that the object meets along the contact force at a place, N/mm: what its force grows by per mm that it is pushed
    against it."""

    at: float

    @property
    def words(self) -> str:
        return f"stiffness at {float(self.at)!r}"


@dataclasses.dataclass(frozen=True)
class ContactLength(Measure):
    """Arc of the front beam between the outermost touching points at a place, mm: how far the finger wraps around the object."""

    at: float

    @property
    def words(self) -> str:
        return f"contact-length at {float(self.at)!r}"


@dataclasses.dataclass(frozen=True)
class Conformity(Measure):
    """How far the contact force is spread along the front beam at a place, mm: the length of an evenly loaded arc with the same
    spread, √12 σ. Where :class:`ContactLength` steps from sample to sample, this changes smoothly, so that a search can follow it."""

    at: float

    @property
    def words(self) -> str:
        return f"conformity at {float(self.at)!r}"


@dataclasses.dataclass(frozen=True)
class MaxStrain(Measure):
    """Largest strain of beams and hinges up to a place, a share: 0.1 is 10 %."""

    at: float

    @property
    def words(self) -> str:
        return f"strain up to {float(self.at)!r}"


@dataclasses.dataclass(frozen=True)
class Snap(Measure):
    """The place at which the finger snaps through; ``up_to`` if it does not before that."""

    up_to: float

    @property
    def words(self) -> str:
        return f"snap up to {float(self.up_to)!r}"


@dataclasses.dataclass(frozen=True)
class Mass(Measure):
    """Mass of the finger, g: beams and lamellae as they are drawn, roots and tip left aside."""

    density_kg_per_m3: float = 1200.0

    @property
    def words(self) -> str:
        return f"mass of {float(self.density_kg_per_m3)!r}"
