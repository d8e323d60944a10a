"""Solved cases."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Generic, Literal, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from . import _core
from .case import Case, CaseLike
from .error import case_error
from .options import DEFAULT, Options
from .record import Record, array, fixed, wrapped
from .status import STATUSES, Status

Array = NDArray[np.float64]
Kind = Literal["finger", "force", "loop", "pressure", "strain"]
T = TypeVar("T")


class _Field(Generic[T]):
    """An attribute of a place, read from its JSON; ``unknown`` stands for null and for an absent name."""

    def __init__(self, unknown: T, doc: str) -> None:
        self.unknown = unknown
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, place: None, owner: type) -> _Field[T]: ...
    @overload
    def __get__(self, place: Place, owner: type) -> T: ...
    def __get__(self, place: Place | None, owner: type) -> T | _Field[T]:
        if place is None:
            return self
        found: T = place._value(self.name, self.unknown)
        return found


def _points(*shape: int) -> Array:
    return fixed(np.full(shape, np.nan))


_NAN = float("nan")
_PAIR = _points(2)


class Place:
    """The result at one place of a motion. The attributes are the names of ``fre solve``'s JSON.

    Without a trustworthy status numbers are NaN, lists are empty and records are None. Names that the JSON has beside these are
    attributes as well.
    """

    __slots__ = ("_json", "_seen", "_status")

    def __init__(self, json: Mapping[str, Any]) -> None:
        self._json = dict(json)
        self._seen: dict[str, Any] = {}

    motor_angle_deg = _Field(_NAN, "Motor angle, degrees; NaN for a translated base.")
    distance_mm = _Field(_NAN, "Distance, mm, of a translated base.")
    force_n = _Field(_PAIR, "Force on the object, world frame, N.")
    force_magnitude_n = _Field(_NAN, "Its magnitude, N.")
    force_finger_frame_n = _Field(_PAIR, "Force on the object, finger frame, N.")
    motor_torque_nmm = _Field(_NAN, "Torque that the contact demands of the motor, N·mm; of a translated base a force, N.")
    energy_nmm = _Field(_NAN, "Elastic energy, N·mm; NaN of a material with memory.")
    gap_mm = _Field(_NAN, "Smallest gap between finger and object, mm; slightly negative in contact.")
    tip_mm = _Field(_PAIR, "Tip of the front beam, finger frame, mm.")
    front_mm = _Field(_points(0, 2), "Front centreline, base to tip, finger frame, mm.")
    back_mm = _Field(_points(0, 2), "Back centreline, base to tip, finger frame, mm.")
    lamellae_mm = _Field(_points(0, 2, 2), "Ends of the lamellae (front, back), base to tip, finger frame, mm.")
    ribs_mm: _Field[tuple[Array, ...]] = _Field((), "Centrelines of ribs, each front to back, base to tip, finger frame, mm.")
    contacts: _Field[tuple[Record, ...]] = _Field((), "Touching samples: arc_mm, position_mm, normal, force_n; with friction tangential_n and state.")
    friction: _Field[Record | None] = _Field(
        None, "Friction: coefficient, normal_n, tangential_n, mobilised, dissipated_nmm; None without."
    )
    force_interval_n: _Field[Record | None] = _Field(
        None, "Between which values the forces lie if the path is unknown: normal, magnitude, torque_nmm; None without friction."
    )
    max_strain: _Field[Record | None] = _Field(None, "Largest strains: front, back, hinge.")
    sensitivity: _Field[Record | None] = _Field(None, "Derivatives by name, such as force_per_deg_n; None with friction or memory.")
    iterations = _Field(0, "Newton iterations since the place before.")
    steps = _Field(0, "Steps of the coordinate since the place before.")
    elapsed_us = _Field(_NAN, "Time since the place before, µs.")
    model: _Field[Record | None] = _Field(None, "The model: scheme, elements_per_beam, elements_per_hinge, unknowns, physics, precision.")
    branch: _Field[int | None] = _Field(None, "Branch, from 1; None once a place had no trustworthy solution.")
    first_branch: _Field[Record | None] = _Field(None, "How far the first branch reaches, and the largest force on it.")
    contact_pressure: _Field[tuple[Record, ...]] = _Field((), "Contact pressure at the touching samples.")
    strains: _Field[Record | None] = _Field(None, "Strains along the beams and in the hinges.")
    beyond_max_strain: _Field[tuple[Record, ...] | None] = _Field(
        None, "What is strained beyond max_strain, or beyond 30 % without one; None without a solution."
    )
    warnings = _Field[tuple[str, ...]]((), "What a person should know of the finger and of this place.")
    overlap_mm: _Field[float | None] = _Field(
        None, "How far the object reaches into a part of the finger that knows no contact; None where it stays clear."
    )

    self_contact: _Field[Record | None] = _Field(
        None, "Two parts of the finger that pass through each other: between, depth_mm, position_mm; None where they stay clear."
    )

    buckling: _Field[Record | None] = _Field(
        None, "The rib that is about to bow or has bowed: rib, load_share; None where none carries 0.8 of its buckling load."
    )

    time_s = _Field(_NAN, "Time since the motion began, s; NaN where no time passes.")

    @property
    def status(self) -> Status:
        """Whether the numbers may be used."""
        return STATUSES[self._json["status"]]

    def to_dict(self) -> dict[str, Any]:
        """The JSON object as it is: null is None. A copy."""
        return copy.deepcopy(self._json)

    def _value(self, name: str, unknown: Any) -> Any:
        if name not in self._seen:
            value = self._json.get(name)
            is_array = isinstance(unknown, np.ndarray)
            if value is None or (value == [] and is_array):
                return unknown
            found = array(value) if is_array else wrapped(value)
            # Ribs of one length are a tuple as all others are, and so is an empty list of records.
            self._seen[name] = tuple(found) if isinstance(found, np.ndarray) and not is_array else found
        return self._seen[name]

    def __getattr__(self, name: str) -> Any:
        json = object.__getattribute__(self, "_json")
        if name.startswith("_") or name not in json:
            raise AttributeError(f"{name}; there is {', '.join(json)}")
        return wrapped(json[name])

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._json]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Place) and self._json == other._json

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        units = {"motor_angle_deg": "°", "distance_mm": " mm", "time_s": " s"}
        where = next((f"{self._json[name]}{unit}" for name, unit in units.items() if name in self._json), "")
        force = f": {self.force_magnitude_n:.4g} N" if self.status.is_trustworthy else ""
        return f"<fre.Place {where} {self.status}{force}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Place, (self._json,)


class Follower:
    """A case on its way: it goes wherever it is sent, from where it is, and so keeps the branch that it is on. It begins where the
    case's motion does, without contact; the case's other places do not matter.

    A pickled follower begins anew where it is unpickled. One thread at a time may send it: each takes a follower of its own.
    """

    __slots__ = ("_case", "_follower", "_options")

    def __init__(self, case: CaseLike, options: Options = DEFAULT) -> None:
        self._case = Case.of(case)
        self._options = options
        self._follower = _core.Follower(self._case._case, options)

    @property
    def case(self) -> Case:
        """The case."""
        return self._case

    def follow(self, to: float, dt_s: float | None = None) -> Place:
        """Goes to a motor angle (degrees) or a distance (mm) within ``dt_s`` seconds; ``first_branch`` is None there. Without a time the
        motion is sudden; the time matters to a material with memory only."""
        return Place(json.loads(self._follower.follow(to, dt_s)))

    def __repr__(self) -> str:
        return f"<fre.Follower of {self._case!r}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Follower, (self._case, self._options)


class Solution(Sequence[Place]):
    """A solved case: a sequence of places, in the case's order. Numbers of all places together are arrays, NaN where the status is
    not trustworthy. A notebook shows its picture."""

    __slots__ = ("_options", "_places", "_solved")

    def __init__(self, options: Options, solved: _core.Solved) -> None:
        self._options = options
        self._solved = solved
        self._places: list[Place | None] = [None] * len(solved)

    @property
    def case(self) -> Case:
        """The case."""
        return Case._of(self._solved.case())

    @property
    def options(self) -> Options:
        """How it was solved."""
        return self._options

    def __len__(self) -> int:
        return len(self._places)

    @overload
    def __getitem__(self, index: int) -> Place: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Place, ...]: ...
    def __getitem__(self, index: int | slice) -> Place | tuple[Place, ...]:
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        index = range(len(self._places))[index]
        place = self._places[index]
        if place is None:
            place = self._places[index] = Place(json.loads(self._solved.place_json(index)))
        return place

    def __iter__(self) -> Iterator[Place]:
        return (self[index] for index in range(len(self)))

    @property
    def status(self) -> tuple[Status, ...]:
        """Statuses, one per place."""
        return tuple(STATUSES[word] for word in self._solved.statuses())

    @property
    def is_trustworthy(self) -> bool:
        """True if every place has a trustworthy status."""
        return all(status.is_trustworthy for status in self.status)

    @property
    def places(self) -> Array:
        """Motor angles in degrees, or distances in mm."""
        return fixed(self._solved.places())

    @property
    def time_s(self) -> Array:
        """Times since the motion began, s; NaN where no time passes."""
        return self._solved.time_s()

    @property
    def force_n(self) -> Array:
        """Forces on the object, world frame, N: a row [x, y] per place."""
        return fixed(self._solved.force_n())

    @property
    def force_magnitude_n(self) -> Array:
        """Their magnitudes, N."""
        return fixed(self._solved.force_magnitude_n())

    @property
    def motor_torque_nmm(self) -> Array:
        """Torques demanded of the motor, N·mm."""
        return fixed(self._solved.motor_torque_nmm())

    @property
    def energy_nmm(self) -> Array:
        """Elastic energies, N·mm."""
        return fixed(self._solved.energy_nmm())

    @property
    def tip_mm(self) -> Array:
        """Tips of the front beam, finger frame, mm: a row [x, y] per place."""
        return fixed(self._solved.tip_mm())

    def column(self, name: str, unknown: float = _NAN) -> Array:
        """A number of every place by its name, with dots into records: ``"max_strain.front"``. Raises :class:`fre.CaseError` for
        what is not a number, or not as many at every place, such as ``"ribs_mm"``."""

        def of(place: Place) -> Any:
            value: Any = place
            for part in name.split("."):
                value = None if value is None else getattr(value, part)
            return unknown if value is None else value

        values = [of(place) for place in self]
        try:
            return fixed(np.array(values, dtype=np.float64))
        except (TypeError, ValueError):
            reason = "a column needs numbers, as many at every place; read it place by place"
            raise case_error(f"{name}: {reason}", name) from None

    @property
    def warnings(self) -> list[str]:
        """What a person should know of these results."""
        return self._solved.warnings()

    def json(self) -> str:
        """The text of ``fre solve --format json``."""
        return self._solved.json()

    def csv(self) -> str:
        """The text of ``fre solve --format csv``."""
        return self._solved.csv()

    def text(self) -> str:
        """The table of ``fre solve``."""
        return self._solved.text()

    def svg(self, *kinds: Kind, at: int | None = None) -> str | None:
        """A picture, kinds one below the other; without kinds the finger and its force. ``at`` is the index of a place; by default
        the last trustworthy one. None if there is nothing to draw."""
        return self._solved.svg(list(kinds), None if at is None else range(len(self))[at])

    def _repr_svg_(self) -> str | None:
        return self.svg()

    def __repr__(self) -> str:
        good = sum(status.is_trustworthy for status in self.status)
        return f"<fre.Solution of {len(self)} places, {good} trustworthy>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.case, self._options, self.json())


def _restored(case: Case, options: Options, text: str) -> Solution:
    return Solution(options, _core.Solved.from_json(case._case, options, text))


def solve(case: CaseLike, options: Options = DEFAULT) -> Solution:
    """Solves a case (or the one in a file): one equilibrium per place of its motion, by continuation from no contact."""
    case = Case.of(case)
    return Solution(options, _core.solve(case._case, options))


def solve_many(
    case: CaseLike,
    values: Mapping[str, Sequence[float] | Array],
    options: Options = DEFAULT,
    *,
    threads: int = 0,
) -> list[Solution]:
    """Solves a case many times, in parallel: once per entry of ``values``, lists of one length by the dotted key of the number that
    they change. ``threads`` is 0 for one per core.

    A status is never an exception: look at ``solution.status``. Values that the case refuses raise :class:`fre.CaseError`.
    """
    case = Case.of(case)
    lists = {key: _numbers(key, list_) for key, list_ in values.items()}
    counts = {key: len(list_) for key, list_ in lists.items()}
    if len(set(counts.values())) > 1:
        found = ", ".join(f"{key} {count}" for key, count in counts.items())
        raise case_error(f"values: needed is one number per case and key; there are {found}", "values")
    table = np.stack(list(lists.values()), axis=1) if lists else np.empty((1, 0))
    solved = _core.solve_many(case._case, list(lists), np.ascontiguousarray(table), options, threads)
    return [Solution(options, one) for one in solved]


def _numbers(key: str, values: Sequence[float] | Array) -> Array:
    """A list of numbers."""
    found = np.atleast_1d(np.asarray(values))
    if found.ndim > 1 or found.dtype.kind not in "biuf":
        raise case_error(f"{key}: allowed is a number or a list of numbers, not {values!r}", key)
    return found.astype(np.float64)
