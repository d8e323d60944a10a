"""Measures, their derivatives, and the search for better designs."""

from __future__ import annotations

import json
import pathlib
import pickle
import subprocess
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import ArrayLike

import fre
from fre import measures
from fre.optimisation import Limit, Problem, optimise, pareto

REDUCED = fre.Options(elements="reduced")
EXACT = {
    "finger.front.thickness_mm": (1.5, 2.6),
    "finger.back.thickness_mm": (1.5, 2.6),
    "finger.hinge.thickness_mm": (0.6, 1.0),
    "finger.hinge.length_mm": (2.0, 3.0),
    "finger.lamellae.heights_mm.2": (26.0, 28.0),
    "finger.back.base_mm.0": (-30.0, -26.0),
    "finger.width_mm": (15.0, 25.0),
    "finger.material.youngs_modulus_pa": (4e7, 6e7),
    "finger.motor.axis_mm.0": (-16.0, -12.0),
    "finger.motor.axis_mm.1": (-22.0, -18.0),
    "object.radius_mm": (36.0, 44.0),
    "object.centre_mm.0": (40.5, 41.5),
    "object.centre_mm.1": (40.0, 50.0),
}


@pytest.fixture
def firm() -> fre.Case:
    return fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([6.0]))




def number(table: object, key: str) -> float:
    for part in key.split("."):
        table = table[int(part)] if isinstance(table, list) else table[part]  # type: ignore[index]
    return float(table)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "measure",
    [measures.Force(at=6.0), measures.MaxStrain(at=6.0), measures.Stiffness(at=6.0), measures.Conformity(at=6.0)],
    ids=lambda measure: type(measure).__name__,
)
def test_derivatives_are_exact(firm: fre.Case, measure: measures.Measure) -> None:
    problem = Problem(firm, EXACT, measure)
    x = problem.own()
    assert problem.values(x) == pytest.approx({key: number(firm.to_dict(), key) for key in EXACT})
    found = problem.gradient(x)
    for column, (key, (least, most)) in enumerate(EXACT.items()):
        assert problem.is_exact(x, key), key
        value = number(firm.to_dict(), key)
        step = 1e-4 * max(abs(value), 1.0)
        near, far = (
            [measure.value(firm.with_values({key: value + sign * part * step})) for sign in (-1.0, 1.0)]
            for part in (1.0, 2.0)
        )
        # Of fourth order.
        expected = (8.0 * (near[1] - near[0]) - (far[1] - far[0])) / (12.0 * step)
        scale = measure.value(firm)
        assert found[column] == pytest.approx((most - least) * expected, rel=1e-5, abs=1e-6 * scale), key


def test_a_problem_has_the_gradient_of_its_value(firm: fre.Case) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.width_mm": (15.0, 25.0)}
    limits: list[Limit] = [(measures.MaxStrain(at=8.0), 0.0, 0.1), (measures.Mass(), 0.0, 20.0)]
    problem = Problem(firm, vary, measures.MeanForce(4.0, 8.0, 5), maximise=True, limits=limits, options=REDUCED)
    x = np.array([0.4, 0.6])
    found, margins = problem.gradient(x), problem.margin_gradients(x)
    assert margins.shape == (4, 2) == (len(problem.margins(x)), 2)
    for column in range(2):
        step = np.zeros(2)
        step[column] = 1e-3
        expected = (problem.value(x + step) - problem.value(x - step)) / 2e-3
        assert found[column] == pytest.approx(expected, rel=1e-4)
        np.testing.assert_allclose(
            margins[:, column], (problem.margins(x + step) - problem.margins(x - step)) / 2e-3, rtol=1e-3, atol=1e-6
        )


def test_nobody_changes_what_a_problem_has_kept(firm: fre.Case) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.width_mm": (15.0, 25.0)}
    problem = Problem(firm, vary, measures.Force(6.0), limits=[(measures.Mass(), 0.0, 20.0)], options=REDUCED)
    x = problem.own()
    for found in (problem.margins(x), problem.gradient(x), problem.margin_gradients(x)):
        before = found.copy()
        with pytest.raises(ValueError, match="read-only"):
            found *= 2.0
        np.testing.assert_array_equal(found, before)


@pytest.mark.parametrize("at", [-1e9, 181.0, np.nan, np.inf])
def test_places_beyond_the_motion_have_no_number(firm: fre.Case, at: float) -> None:
    for measure in (measures.Force(at), measures.MaxStrain(at), measures.Snap(at), measures.Stiffness(at)):
        with pytest.raises(fre.CaseError):
            measure.value(firm)
    with pytest.raises(fre.CaseError, match="-1000000000° is beyond the motion; allowed is -180 to 180°"):
        measures.Force(-1e9).value(firm)


def test_measures_are_what_they_say(firm: fre.Case) -> None:
    case = firm.with_motion(fre.Rotation([0.0, 4.0, 5.0, 6.0]))
    solution = fre.solve(case)
    forces = solution.force_magnitude_n[1:]
    assert measures.Force(6.0).value(case) == pytest.approx(forces[-1], rel=1e-9)
    assert measures.ForceVariation(4.0, 6.0, 3).value(case) == pytest.approx(np.ptp(forces) / forces.mean(), rel=1e-9)
    assert measures.MeanForce(4.0, 6.0, 3).value(case) == pytest.approx(forces.mean(), rel=1e-9)
    last = solution[-1]
    contacts = last.contacts
    assert measures.ContactLength(6.0).value(case) == pytest.approx(contacts[-1].arc_mm - contacts[0].arc_mm)
    arcs, weights = (np.array([contact[name] for contact in contacts]) for name in ("arc_mm", "force_n"))
    spread = np.average((arcs - np.average(arcs, weights=weights)) ** 2, weights=weights)
    assert measures.Conformity(6.0).value(case) == pytest.approx(np.sqrt(12.0 * spread), rel=1e-6)
    strains = [max(place.to_dict()["max_strain"].values()) for place in solution]
    assert measures.MaxStrain(6.0).value(case) == pytest.approx(max(strains), rel=1e-9)
    # Pushing the object a little against its force makes that force larger by the stiffness.
    along = last.force_n / last.force_magnitude_n
    moved = firm.with_values({f"object.centre_mm.{axis}": c - 1e-4 * along[axis] for axis, c in enumerate((41.0, 45.0))})
    change = (fre.solve(moved)[0].force_n - last.force_n) @ along / 1e-4
    assert measures.Stiffness(6.0).value(case) == pytest.approx(change, rel=1e-3)
    # Two beams of 80 and 84.8 mm, 2 mm thick, and seven lamellae, 20 mm wide, of 1.2 g/cm³.
    lamellae = sum(28.0 * (1.0 - height / 80.0) for height in range(9, 64, 9)) * 3.0
    assert measures.Mass(1200.0).value(case) == pytest.approx((80.0 * 2.0 + np.hypot(28.0, 80.0) * 2.0 + lamellae) * 20.0 * 1.2e-3)
    assert measures.Snap(6.0).value(case) == 6.0
    first = fre.solve(firm.with_motion(fre.Rotation(np.arange(0.0, 41.0))))[-1].first_branch
    assert first is not None
    low, high = first.snap_between_deg
    assert low - 1e-3 <= measures.Snap(40.0).value(case) <= high + 1e-3
    with pytest.raises(measures.Unreached):
        measures.Stiffness(0.0).value(fre.Case("preset:ladder-80", fre.Circle(40.0, (60.0, 45.0)), fre.Rotation([1.0])))


def test_a_search_keeps_limits_and_goes_on_where_it_was(firm: fre.Case, tmp_path: pathlib.Path) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    limits: list[Limit] = [(measures.MaxStrain(at=6.0), 0.0, 0.06)]

    def problem() -> Problem:
        return Problem(firm, vary, measures.Force(at=6.0), maximise=True, limits=limits, options=REDUCED)

    log = tmp_path / "search.json"
    told: list[tuple[int, int]] = []
    best = optimise(problem(), starts=2, most=40, log=log, progress=lambda done, total, goal: told.append((done, total)))
    assert told == [(1, 2), (2, 2)]
    kept = best.problem.margins(best.x)
    assert kept.min() > -1e-6 and best.gain > 0.0
    again = problem()
    same = optimise(again, starts=2, most=40, log=log)
    assert same.tries == best.tries and again.evaluations == 0
    # A start by itself, from an unpickled problem, is the same to the last bit.
    assert pickle.loads(pickle.dumps(again)).search(1, most=40) == best.tries[1]
    assert "kept" in best.report() and all("<svg" in (picture or "") for picture in best.pictures())
    assert "<!DOCTYPE html>" in best.page()
    assert best.case.finger["front.thickness_mm"] == best.problem.values(best.x)["finger.front.thickness_mm"]
    other = Problem(firm, vary, measures.Force(at=5.0), options=REDUCED)
    with pytest.raises(FileExistsError, match="another problem"):
        optimise(other, log=log)


def test_scipy_takes_the_same_functions(firm: fre.Case) -> None:
    from scipy.optimize import minimize

    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    limits: list[Limit] = [(measures.MaxStrain(at=6.0), 0.0, 0.06)]
    problem = Problem(firm, vary, measures.Force(at=6.0), maximise=True, limits=limits, options=REDUCED)
    constraint = {"type": "ineq", "fun": problem.margins, "jac": problem.margin_gradients}
    found = minimize(
        problem.value, problem.own(), jac=problem.gradient, bounds=[(0.0, 1.0)] * 2, constraints=[constraint], method="SLSQP"
    )
    own = optimise(problem, starts=1, most=60)
    assert found.fun == pytest.approx(problem.value(own.x), rel=1e-3)


def test_the_command_finds_the_same(program: str, firm: fre.Case, tmp_path: pathlib.Path) -> None:
    file, out = tmp_path / "case.toml", tmp_path / "found"
    file.write_text(firm.toml())
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    problem = Problem(firm, vary, measures.Mass(), limits=[(measures.Force(at=6.0), 2.7, np.inf)], options=REDUCED)
    best = optimise(problem, starts=2)
    words: list[str | pathlib.Path] = [program, "optimise", file, "--goal", "mass", "--subject-to", "force at 6 >= 2.7"]
    for key, (least, most) in vary.items():
        words += ["--vary", f"{key}={least}:{most}"]
    words += ["--starts", "2", "--elements", "reduced", "--out", out, "--format", "json"]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    found, expected = json.loads(run.stdout)["report"], best.to_dict()
    for report in (found, expected):
        report.pop("seconds"), report.pop("cases_solved")
    assert found == expected
    assert fre.Case.read(out / "design.toml").finger["front.thickness_mm"] == best.case.finger["front.thickness_mm"]


def test_a_front_of_two_goals_falls(firm: fre.Case) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    problem = Problem(firm, vary, measures.Force(at=6.0), maximise=True, options=REDUCED)
    front = pareto(problem, measures.MaxStrain(at=6.0), points=4, starts=1)
    forces, strains = np.array([point["goals"] for point in front.points]).T
    assert len(forces) >= 3 and (np.diff(forces) < 0.0).all() and (np.diff(strains) < 0.0).all()
    assert "<svg" in front.svg and "largest force at 6" in front.text
    assert measures.Force(at=6.0).value(front.case(0), REDUCED) == pytest.approx(forces[0], rel=1e-9)


def test_what_cannot_be_varied_is_refused(firm: fre.Case) -> None:
    with pytest.raises(fre.CaseError, match="at least one key"):
        Problem(firm, {}, measures.Force(6.0))
    with pytest.raises(fre.CaseError, match="must be less"):
        Problem(firm, {"object.radius_mm": (40.0, 40.0)}, measures.Force(6.0))
    with pytest.raises(fre.CaseError) as error:
        Problem(firm, {"object.size": (30.0, 40.0)}, measures.Force(6.0))
    assert error.value.key == "object.size"
    with pytest.raises(fre.CaseError) as error:
        Problem(firm, {"object.friction": (0.0, 1.0)}, measures.Force(6.0))
    assert error.value.key == "object.friction"
    with pytest.raises(fre.CaseError, match="count = 1"):
        Problem(firm, EXACT, measures.MeanForce(4.0, 8.0, 1))


def test_what_no_problem_takes_is_refused_by_name(firm: fre.Case) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 3.0), "finger.back.thickness_mm": (1.5, 3.0)}
    goal = measures.Force(at=6.0)
    problem = Problem(firm, vary, goal, options=REDUCED)
    wrong: list[ArrayLike] = [[], [0.5], [0.5, 0.5, 0.5], 0.5, [[0.5, 0.5]], [np.nan, 0.5]]
    functions: list[Callable[[ArrayLike], object]] = [
        problem.value, problem.gradient, problem.margin_gradients, problem.values, problem.case
    ]
    for x in wrong:
        for function in functions:
            with pytest.raises(fre.CaseError, match="^x: ") as refused:
                function(x)
            assert refused.value.key == "x"
    for bounds in [(0.05, 0.0), (np.nan, 1.0), (0.0, np.nan), (np.inf, np.inf), (-np.inf, -np.inf)]:
        with pytest.raises(fre.CaseError, match="limits: strain up to"):
            Problem(firm, vary, goal, limits=[(measures.MaxStrain(at=6.0), *bounds)])
    for name, number in [("starts", 0), ("most", 0), ("tolerance", -1.0), ("points", 1)]:
        with pytest.raises(fre.CaseError, match=f"^{name} = {number}") as refused:
            pareto(problem, measures.MaxStrain(at=6.0), **{name: number})  # type: ignore[arg-type]
        assert refused.value.key == name
    for first, last, count in [(6.0, 0.0, 3), (6.0, 6.0, 3), (0.0, 12.0, 1001)]:
        with pytest.raises(fre.CaseError):
            measures.MeanForce(first, last, count).words
