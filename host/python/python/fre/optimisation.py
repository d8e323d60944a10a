"""Design optimisation: goals and limits of :mod:`fre.measures` over any numbers of a case (``pip install fre[optimise]``).

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

``problem.value`` and ``problem.gradient`` are what ``scipy.optimize`` takes, over variables from 0 to 1 between their bounds.
"""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize
from scipy.stats import qmc

from ._core import CaseError
from .case import Case, CaseLike
from .measures import Measure, Unreached, closing
from .options import DEFAULT, Options
from .solution import Solution, solve, solve_many

Array = NDArray[np.float64]
Limit = tuple[Measure, float, float]
"""A measure with its least and its most."""

STEP = 1e-4
"""Step of differences, as a share of a variable's range."""
UNREACHED = 1e3
"""What stands for the goal where it has no number: the search turns back there."""


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
        if not vary:
            raise CaseError("vary: at least one key with its bounds is needed")
        for key, (least, most) in vary.items():
            if not least < most:
                raise CaseError(f"vary: {key} = {least}:{most}: the first bound must be less than the second")
        self.keys = list(vary)
        self.bounds = np.array([vary[key] for key in self.keys], dtype=float)
        self.goal, self.limits, self.sign = goal, list(limits), -1.0 if maximise else 1.0
        self.options = options
        case = Case.of(case)
        wanted = [goal, *(limit[0] for limit in limits)]
        self.cases = [closing(wanted, case.with_values(values)) for values in ({}, *objects)]
        self.evaluations = 0
        """Solved cases so far."""
        self._seen: dict[bytes, list[Solution] | None] = {}
        self._slopes: dict[bytes, Array] = {}
        for key in self.keys:
            # A key that is unknown is refused here, and not in the middle of the work.
            self.cases[0].with_values({key: float(np.mean(vary[key]))})

    def values(self, x: ArrayLike) -> dict[str, float]:
        """The numbers by their keys at variables from 0 to 1."""
        least, most = self.bounds.T
        found = least + np.clip(np.asarray(x, dtype=float), 0.0, 1.0) * (most - least)
        return dict(zip(self.keys, found.tolist()))

    def variables(self, case: CaseLike) -> Array:
        """The variables of a case's own numbers, as near as the bounds allow."""
        table = Case.of(case).to_dict()
        own = [_number(table, key) for key in self.keys]
        least, most = self.bounds.T
        return np.asarray(np.clip((np.array(own) - least) / (most - least), 0.0, 1.0))

    def solutions(self, x: ArrayLike) -> list[Solution] | None:
        """The solutions at variables, one per object; None where the finger cannot be made."""
        name = np.asarray(x, dtype=float).tobytes()
        if name not in self._seen:
            self._seen[name] = self._solve([self.values(x)])[0]
        return self._seen[name]

    def value(self, x: ArrayLike) -> float:
        """The goal, to be made small; its negative if it shall be large."""
        return self._read(self.goal, self.sign, self.solutions(x))

    def margins(self, x: ArrayLike) -> Array:
        """How far the limits are kept, as a share of them: two numbers per limit, 0 and more where it is kept."""
        solutions = self.solutions(x)
        return np.array([margin for limit in self.limits for margin in self._margins(limit, solutions)])

    def gradient(self, x: ArrayLike) -> Array:
        """Derivative of the goal with the variables. From the solver's sensitivities where they are enough, else from differences."""
        return np.asarray(self._jacobian(x)[0])

    def margin_gradients(self, x: ArrayLike) -> Array:
        """Derivatives of the margins with the variables: a row per margin."""
        return np.asarray(self._jacobian(x)[1:])

    def is_exact(self, x: ArrayLike, key: str) -> bool:
        """Whether the goal's derivative with a key comes from the solver's sensitivities, at these variables."""
        solutions = self.solutions(x)
        return solutions is not None and self._slope(self.goal, self.sign, solutions, key) is not None

    def report(self, x: ArrayLike) -> str:
        """Goal, limits and variables in words."""
        solutions = self.solutions(x)
        lines = [f"{self.goal!r}: {_words(self.sign * self.value(x), self.goal.unit)}"]
        for limit in self.limits:
            kept = min(self._margins(limit, solutions)) >= -1e-6
            found = self._read(limit[0], 1.0, solutions)
            state = "kept" if kept else "NOT KEPT"
            lines.append(f"{limit[0]!r}: {_words(found, limit[0].unit)}, allowed {limit[1]:g} to {limit[2]:g}: {state}")
        lines += [f"{key} = {value:.6g}" for key, value in self.values(x).items()]
        return "\n".join(lines)

    # What follows reads measures of solutions.

    def _solve(self, points: list[dict[str, float]]) -> list[list[Solution] | None]:
        found: list[list[Solution] | None] = [[] for _ in points]
        for case in self.cases:
            for index, solution in enumerate(self._batch(case, points)):
                one = found[index]
                if solution is None:
                    found[index] = None
                elif one is not None:
                    one.append(solution)
        self.evaluations += len(points) * len(self.cases)
        return found

    def _batch(self, case: Case, points: list[dict[str, float]]) -> list[Solution | None]:
        try:
            return list(solve_many(case, {key: [point[key] for point in points] for key in self.keys}, self.options))
        except CaseError:
            if len(points) == 1:
                return [None]
            # One of them cannot be made.
            return [self._batch(case, [point])[0] for point in points]

    def _read(self, measure: Measure, sign: float, solutions: list[Solution] | None) -> float:
        if solutions is None:
            return UNREACHED
        try:
            # The worst object's: the largest of what shall be small.
            return max(sign * measure.value(solution) for solution in solutions)
        except Unreached:
            return UNREACHED

    def _slope(self, measure: Measure, sign: float, solutions: list[Solution], key: str) -> float | None:
        try:
            worst = max(solutions, key=lambda solution: sign * measure.value(solution))
            slope = measure.slope(worst, key)
        except Unreached:
            return None
        return None if slope is None else sign * slope

    def _margins(self, limit: Limit, solutions: list[Solution] | None) -> list[float]:
        measure, least, most = limit
        scale = max(abs(bound) for bound in (least, most) if np.isfinite(bound)) or 1.0
        return [
            -(self._read(measure, sign, solutions) - sign * bound) / scale
            for sign, bound in ((-1.0, least), (1.0, most))
            if np.isfinite(bound)
        ]

    def _functions(self) -> list[Callable[[list[Solution] | None], float]]:
        goal = [lambda solutions: self._read(self.goal, self.sign, solutions)]
        bounds = [
            (limit, index)
            for limit in self.limits
            for index in range(int(np.isfinite(limit[1])) + int(np.isfinite(limit[2])))
        ]
        return [*goal, *((lambda s, limit=limit, index=index: self._margins(limit, s)[index]) for limit, index in bounds)]

    def _jacobian(self, x: ArrayLike) -> Array:
        x = np.asarray(x, dtype=float)
        name = x.tobytes()
        if name in self._slopes:
            return self._slopes[name]
        functions = self._functions()
        here = self.solutions(x)
        table = np.zeros((len(functions), len(self.keys)))
        ranges = self.bounds[:, 1] - self.bounds[:, 0]
        wanted: list[int] = []
        for column, key in enumerate(self.keys):
            exact = None if here is None else self._slope(self.goal, self.sign, here, key)
            if exact is not None:
                table[0, column] = exact * ranges[column]
            if exact is None or self.limits:
                wanted.append(column)
        points = []
        for column in wanted:
            for step in (-STEP, STEP):
                moved = x.copy()
                moved[column] = np.clip(moved[column] + step, 0.0, 1.0)
                points.append(moved)
        solved = self._solve([self.values(point) for point in points]) if points else []
        for index, column in enumerate(wanted):
            low, high = points[2 * index][column], points[2 * index + 1][column]
            for row, function in enumerate(functions):
                if row == 0 and here is not None and self._slope(self.goal, self.sign, here, self.keys[column]) is not None:
                    continue
                below, above = function(solved[2 * index]), function(solved[2 * index + 1])
                table[row, column] = (above - below) / (high - low)
        self._slopes[name] = table
        return table


@dataclasses.dataclass(frozen=True)
class Optimum:
    """What came of a search."""

    problem: Problem
    start: Array
    """Variables of the case as it was."""
    x: Array
    """Variables of the best design that keeps all limits."""
    tries: list[dict[str, Any]]
    """What came of every start: ``start``, ``x``, ``value``, ``kept`` (the smallest margin) and ``message``."""

    @property
    def case(self) -> Case:
        """The case with the best design."""
        return self.problem.cases[0].with_values(self.problem.values(self.x))

    @property
    def gain(self) -> float:
        """How much better the goal is than before, as a share of it."""
        before, after = self.problem.value(self.start), self.problem.value(self.x)
        return (before - after) / abs(before)

    def report(self) -> str:
        """Before and after in words."""
        return f"before\n{self.problem.report(self.start)}\n\nafter ({100 * self.gain:+.1f} %)\n{self.problem.report(self.x)}\n"

    def pictures(self) -> tuple[str | None, str | None]:
        """The finger and its force before and after, as SVG."""
        before = solve(self.problem.cases[0].with_values(self.problem.values(self.start)), self.problem.options)
        return before.svg(), solve(self.case, self.problem.options).svg()


def optimise(
    problem: Problem,
    *,
    starts: int = 4,
    seed: int = 0,
    tolerance: float = 1e-5,
    most: int = 60,
    log: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, float], object] | None = None,
) -> Optimum:
    """Searches for the best design by SLSQP, from the case as it is and from further starts spread over the bounds.

    ``log`` is a file in which every finished start is kept: the same call goes on after its program was stopped. ``progress`` is
    called with the starts that are done, all starts, and the best goal so far.
    """
    own = problem.variables(problem.cases[0])
    spread = qmc.LatinHypercube(len(problem.keys), rng=seed).random(starts - 1) if starts > 1 else []
    kept = _Log(log, problem, starts, seed)
    tries = list(kept.tries)
    for number, start in enumerate([own, *spread]):
        if number >= len(tries):
            tries.append(_search(problem, start, tolerance, most))
            kept.add(tries[-1])
        if progress is not None:
            progress(number + 1, starts, problem.sign * min((one["value"] for one in tries if one["kept"] >= -1e-6), default=np.nan))
    # Starts that break a limit count only if none keeps all.
    best = min(tries, key=lambda one: (one["kept"] < -1e-6, one["value"]))
    return Optimum(problem, own, np.array(best["x"]), tries)


def pareto(
    problem: Problem, second: Measure, bounds: Sequence[float], *, maximise: bool = False, starts: int = 2, seed: int = 0
) -> Iterator[tuple[float, Optimum]]:
    """The front of two goals: the best of the problem's goal for every bound of the second one, which is held at most there (at least,
    if it shall be large)."""
    for bound in bounds:
        limit = (second, bound, np.inf) if maximise else (second, -np.inf, bound)
        narrowed = Problem.__new__(Problem)
        narrowed.__dict__ = {**problem.__dict__, "limits": [*problem.limits, limit], "_seen": {}, "_slopes": {}}
        narrowed.cases = [closing([problem.goal, second, *(one[0] for one in problem.limits)], case) for case in problem.cases]
        yield bound, optimise(narrowed, starts=starts, seed=seed)


def _search(problem: Problem, start: Array, tolerance: float, most: int) -> dict[str, Any]:
    scale = max(abs(problem.value(start)), 1e-9)
    limits = {"type": "ineq", "fun": problem.margins, "jac": problem.margin_gradients}
    found = minimize(
        lambda x: problem.value(x) / scale,
        start,
        jac=lambda x: problem.gradient(x) / scale,
        bounds=[(0.0, 1.0)] * len(start),
        constraints=[limits] if problem.limits else [],
        method="SLSQP",
        options={"ftol": tolerance, "maxiter": most},
    )
    x = np.clip(found.x, 0.0, 1.0)
    margins = problem.margins(x)
    return {
        "start": start.tolist(),
        "x": x.tolist(),
        "value": problem.value(x),
        "kept": float(margins.min()) if len(margins) else 0.0,
        "message": str(found.message),
    }


class _Log:
    """Finished starts in a file."""

    def __init__(self, path: str | os.PathLike[str] | None, problem: Problem, starts: int, seed: int) -> None:
        self.path = None if path is None else pathlib.Path(path)
        cases = [case.toml() for case in problem.cases]
        limits = [(repr(measure), least, most) for measure, least, most in problem.limits]
        what = [cases, problem.keys, problem.bounds.tolist(), repr(problem.goal), problem.sign, limits, repr(problem.options), seed]
        self.identity = json.loads(json.dumps(what))
        self.tries: list[dict[str, Any]] = []
        if self.path is not None and self.path.exists():
            found = json.loads(self.path.read_text(encoding="utf-8"))
            if found["problem"] != self.identity:
                raise FileExistsError(f"{self.path} is of another problem; remove it, or give another name")
            self.tries = found["tries"][:starts]

    def add(self, one: dict[str, Any]) -> None:
        self.tries.append(one)
        if self.path is not None:
            beside = self.path.with_name(self.path.name + ".partial")
            beside.write_text(json.dumps({"problem": self.identity, "tries": self.tries}), encoding="utf-8")
            os.replace(beside, self.path)


def _number(table: Any, key: str) -> float:
    for part in key.split("."):
        table = table[int(part)] if isinstance(table, list) else table[part]
    return float(table)


def _words(value: float, unit: str) -> str:
    return "not reached" if abs(value) >= UNREACHED else f"{value:.5g} {unit}".strip()
