"""Design optimisation: goals and limits of :mod:`fre.measures` over any numbers of a case, by the optimiser of ``fre optimise``.

>>> import fre
>>> from fre import measures
>>> from fre.optimisation import Problem
>>> case = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([6.0]))
>>> problem = Problem(
...     case,
...     vary={"finger.front.thickness_mm": (1.5, 3.0), "finger.back.thickness_mm": (1.5, 3.0)},
...     goal=measures.Force(at=6.0),
...     maximise=True,
...     limits=[(measures.MaxStrain(at=6.0), 0.0, 0.05)],
... )
>>> bool(problem.value([0.5, 0.5]) < 0.0)
True

``problem.value`` and ``problem.gradient``, ``problem.margins`` and ``problem.margin_gradients`` are what ``scipy.optimize`` takes, over
variables from 0 to 1 between their bounds. The arrays are read-only.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .case import Case, CaseLike
from .error import case_error
from .measures import Measure
from .options import DEFAULT, Options
from .record import fixed

Array = NDArray[np.float64]
Limit = tuple[Measure, float, float]
"""A measure with its least and its most: ``-math.inf`` and ``math.inf`` where there is none."""

STARTS = 4
MOST = 100
TOLERANCE = 1e-5


class Problem:
    """Goal and limits as functions of variables. Several ``objects`` are grasped one after the other; a measure then counts by its
    worst object."""

    def __init__(
        self,
        case: CaseLike,
        vary: Mapping[str, tuple[float, float]],
        goal: Measure,
        *,
        maximise: bool = False,
        limits: Sequence[Limit] = (),
        objects: Sequence[Mapping[str, float]] = (),
        options: Options = DEFAULT,
    ) -> None:
        """A problem over the numbers at the dotted keys of ``vary``, each between two bounds. ``objects`` are the numbers that make
        the other objects, such as ``{"object.radius_mm": 20.0, "object.centre_mm.0": 21.0}``."""
        self._arguments = (Case.of(case).toml(), dict(vary), goal, maximise, list(limits), [dict(one) for one in objects], options)
        self.keys = list(vary)
        self.goal, self.limits, self.options = goal, list(limits), options
        self._problem = _core.Problem(
            Case.of(case)._case,
            [(key, float(least), float(most)) for key, (least, most) in vary.items()],
            _goal(goal, maximise),
            [(measure.words, *_bounds(measure, float(least), float(most))) for measure, least, most in limits],
            [[(key, float(number)) for key, number in one.items()] for one in objects],
            options,
        )
        self._values: dict[bytes, Array] = {}
        self._slopes: dict[bytes, tuple[Array, NDArray[np.bool_]]] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, self._arguments

    @property
    def identity(self) -> str:
        """What says which problem it is."""
        case, vary, goal, maximise, limits, objects, options = self._arguments
        asked = [(measure.words, least, most) for measure, least, most in limits]
        return repr((_core.VERSION, case, vary, _goal(goal, maximise), asked, objects, options))

    @property
    def evaluations(self) -> int:
        """Solved cases so far."""
        return self._problem.solved()

    def values(self, x: ArrayLike) -> dict[str, float]:
        """The numbers by their keys at variables from 0 to 1."""
        return dict(zip(self.keys, self._problem.numbers(self._list(x))))

    def own(self) -> Array:
        """The variables of the case as it is, as near as the bounds allow."""
        return np.array(self._problem.own())

    def case(self, x: ArrayLike, object: int = 0) -> Case:
        """The case at variables, with one of the objects."""
        return Case.parse(self._problem.case(self._list(x), object).toml())

    def value(self, x: ArrayLike) -> float:
        """The goal, to be made small; its negative if it shall be large."""
        return float(self._at(x)[0])

    def margins(self, x: ArrayLike) -> Array:
        """How far the limits are kept, as a share of them: one number per bound, 0 and more where it is kept."""
        return self._at(x)[1:]

    def gradient(self, x: ArrayLike) -> Array:
        """Derivative of the goal with the variables: the solver's own, but for the place of a snap-through, which is differenced."""
        return np.asarray(self._slopes_at(x)[0][0])

    def margin_gradients(self, x: ArrayLike) -> Array:
        """Derivatives of the margins with the variables: a row per margin."""
        return np.asarray(self._slopes_at(x)[0][1:])

    def is_exact(self, x: ArrayLike, key: str) -> bool:
        """Whether the goal's derivative with a key comes from the solver's sensitivities, at these variables."""
        return bool(self._slopes_at(x)[1][0][self.keys.index(key)])

    def search(self, number: int, *, seed: int = 0, most: int = MOST, tolerance: float = TOLERANCE) -> dict[str, Any]:
        """One start of a search, the same whatever machine runs it: 0 is the case as it is, all others are random. See
        :attr:`Optimum.tries`."""
        check_search(1, most, tolerance)
        found: dict[str, Any] = json.loads(self._problem.search(number, (1, seed, most, tolerance)))
        return found

    def _list(self, x: ArrayLike) -> list[float]:
        """The variables, one for each key."""
        found = np.asarray(x, dtype=float)
        if found.shape != (len(self.keys),):
            shape = f"shape {found.shape}" if found.ndim != 1 else f"{len(found)} numbers"
            raise case_error(f"x: has {shape}; allowed is a list of {len(self.keys)}, one for each of {', '.join(self.keys)}", "x")
        if not np.isfinite(found).all():
            raise case_error(f"x: is {found.tolist()}; allowed are finite numbers", "x")
        listed: list[float] = found.tolist()
        return listed

    def _at(self, x: ArrayLike) -> Array:
        x = self._list(x)
        name = np.array(x).tobytes()
        if name not in self._values:
            self._values[name] = fixed(self._problem.values(x))
        return self._values[name]

    def _slopes_at(self, x: ArrayLike) -> tuple[Array, NDArray[np.bool_]]:
        x = self._list(x)
        name = np.array(x).tobytes()
        if name not in self._slopes:
            slopes, exact = self._problem.slopes(x)
            self._slopes[name] = (fixed(slopes), exact)
        return self._slopes[name]


@dataclasses.dataclass(frozen=True)
class Optimum:
    """What came of a search."""

    problem: Problem
    tries: list[dict[str, Any]]
    """What came of every start: ``start``, ``x``, ``value``, ``kept`` (the smallest margin) and ``ended``."""
    seconds: float = 0.0

    @property
    def start(self) -> Array:
        """Variables of the case as it was."""
        return self.problem.own()

    @property
    def is_kept(self) -> bool:
        """Whether the best design keeps all limits."""
        return bool(self.to_dict()["kept"])

    @property
    def x(self) -> Array:
        """Variables of the best design that keeps all limits; where none does, of the one that breaks them least (:attr:`is_kept`)."""
        return np.array(self.to_dict()["x"])

    @property
    def case(self) -> Case:
        """The case with the best design."""
        return self.problem.case(self.x)

    @property
    def gain(self) -> float:
        """How much better the goal is than that of the case as it was, as a share of it."""
        percent = self.to_dict()["goal"]["better_percent"]
        return float("nan") if percent is None else float(percent) / 100.0

    def to_dict(self) -> dict[str, Any]:
        """Goal, limits and variables before and after, as ``fre optimise --format json`` has them."""
        found: dict[str, Any] = json.loads(self._report()[0])
        return found

    def report(self) -> str:
        """Before and after as a table."""
        return self._report()[1]

    def page(self) -> str:
        """The report with its pictures as one HTML page."""
        return self._report()[2]

    def pictures(self, object: int = 0) -> tuple[str | None, str | None]:
        """The finger and its force before and after, as SVG."""
        return self.problem._problem.pictures(self.x.tolist(), object)

    def _report(self) -> tuple[str, str, str]:
        return self.problem._problem.report(json.dumps(self.tries), self.seconds)


def optimise(
    problem: Problem,
    *,
    starts: int = STARTS,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    most: int = MOST,
    log: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, float], object] | None = None,
) -> Optimum:
    """Searches for the best design by SLSQP, from the case as it is and from random starts.

    ``log`` is a file in which every finished start is kept: the same call goes on after its program was stopped. ``progress`` is
    called with the starts that are done, all starts, and the best goal so far.
    """
    check_search(starts, most, tolerance)
    begin = time.perf_counter()
    path = None if log is None else os.fspath(log)
    found = json.loads(problem._problem.optimise((starts, seed, most, tolerance), path, progress))
    return Optimum(problem, found, time.perf_counter() - begin)


@dataclasses.dataclass(frozen=True)
class Front:
    """The front of two goals: no design is better than one of these in both."""

    problem: Problem
    points: list[dict[str, Any]]
    """From the best of the first goal to the best of the second: ``goals`` (both), ``x`` and ``kept``."""
    text: str
    """The front as a table."""
    svg: str
    """The front as a picture."""

    def case(self, index: int) -> Case:
        """The case of a point."""
        return self.problem.case(self.points[index]["x"])

    def _repr_svg_(self) -> str:
        return self.svg


def pareto(
    problem: Problem,
    second: Measure,
    *,
    maximise: bool = False,
    points: int = 8,
    starts: int = 2,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    most: int = MOST,
    log: str | os.PathLike[str] | None = None,
) -> Front:
    """The front of the problem's goal and a second one, which is large or small as ``maximise`` says: the best of both, and the best
    of the first with the second held at values between."""
    check_search(starts, most, tolerance)
    if not 2 <= points <= 200:
        raise case_error(f"points = {points}: allowed is 2 to 200", "points")
    path = None if log is None else os.fspath(log)
    search = (starts, seed, most, tolerance)
    found, text, svg = problem._problem.front(_goal(second, maximise), points, search, path)
    return Front(problem, json.loads(found), text, svg)


def _bounds(measure: Measure, least: float, most: float) -> tuple[float, float]:
    """A limit's bounds."""
    if not (least <= most and least < math.inf and most > -math.inf):
        allowed = "the least first, -inf for none and inf for no most"
        raise case_error(f"limits: {measure.words} from {least} to {most}; allowed is {allowed}", "limits")
    return least, most


def check_search(starts: int, most: int, tolerance: float) -> None:
    """Refuses what no search goes by, as ``fre optimise`` does."""
    for name, number, largest in [("starts", starts, 10_000), ("most", most, 1_000_000)]:
        if not 1 <= number <= largest:
            raise case_error(f"{name} = {number}: allowed is 1 to {largest}", name)
    if not 0.0 < tolerance < math.inf:
        raise case_error(f"tolerance = {tolerance}: allowed is a positive number", "tolerance")


def _goal(measure: Measure, maximise: bool) -> str:
    return f"{'largest' if maximise else 'least'} {measure.words}"


def _again(
    case: str,
    vary: dict[str, tuple[float, float]],
    goal: Measure,
    maximise: bool,
    limits: list[Limit],
    objects: list[dict[str, float]],
    options: Options,
) -> Problem:
    return Problem(Case.parse(case), vary, goal, maximise=maximise, limits=limits, objects=objects, options=options)

