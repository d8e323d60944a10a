"""Measures, their derivatives, and the search for better designs."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

import fre
from fre import measures
from fre.optimisation import Limit, Problem, optimise, pareto

REDUCED = fre.Options(elements="reduced")
EXACT = {
    "finger.front.thickness_mm": (1.5, 2.6),
    "finger.back.thickness_mm": (1.5, 2.6),
    "finger.hinge.thickness_mm": (0.6, 1.0),
    "finger.hinge.length_mm": (2.0, 3.0),
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


@pytest.mark.parametrize("key", list(EXACT))
def test_derivatives_of_the_force_are_those_of_differences(firm: fre.Case, key: str) -> None:
    measure = measures.Force(at=6.0)
    solution = fre.solve(measures.closing([measure], firm))
    slope = measure.slope(solution, key)
    assert slope is not None
    own = float(np.mean(EXACT[key])) if key == "finger.material.youngs_modulus_pa" else None
    table: object = firm.to_dict()
    for part in key.split("."):
        table = table[int(part)] if isinstance(table, list) else table[part]  # type: ignore[index]
    value = float(table)  # type: ignore[arg-type]
    assert own is None or own > 0.0
    step = 1e-5 * max(abs(value), 1.0)
    below, above = (
        measure.value(fre.solve(measures.closing([measure], firm.with_values({key: value + sign * step}))))
        for sign in (-1.0, 1.0)
    )
    assert slope == pytest.approx((above - below) / (2.0 * step), rel=1e-5), key


def test_a_problem_has_the_gradient_of_its_value(firm: fre.Case) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.width_mm": (15.0, 25.0)}
    limits: list[Limit] = [(measures.MaxStrain(at=8.0), 0.0, 0.1), (measures.Mass(), 0.0, 20.0)]
    problem = Problem(firm, vary, measures.MeanForce(4.0, 8.0, 5), maximise=True, limits=limits, options=REDUCED)
    x = np.array([0.4, 0.6])
    assert problem.is_exact(x, "finger.front.thickness_mm") and not problem.is_exact(x, "finger.width_mm")
    found, margins = problem.gradient(x), problem.margin_gradients(x)
    for column in range(2):
        step = np.zeros(2)
        step[column] = 1e-3
        expected = (problem.value(x + step) - problem.value(x - step)) / 2e-3
        assert found[column] == pytest.approx(expected, rel=1e-4)
        np.testing.assert_allclose(
            margins[:, column], (problem.margins(x + step) - problem.margins(x - step)) / 2e-3, rtol=1e-3, atol=1e-6
        )


def test_measures_are_what_they_say(firm: fre.Case) -> None:
    solution = fre.solve(firm.with_motion(fre.Rotation([0.0, 4.0, 5.0, 6.0])))
    forces = solution.force_magnitude_n[1:]
    assert measures.ForceVariation(4.0, 6.0, 3).value(solution) == pytest.approx(np.ptp(forces) / forces.mean())
    assert measures.MeanForce(4.0, 6.0, 3).value(solution) == pytest.approx(forces.mean())
    last = solution[-1]
    contacts = last.contacts
    assert measures.ContactLength(6.0).value(solution) == contacts[-1].arc_mm - contacts[0].arc_mm
    arcs, weights = (np.array([contact[name] for contact in contacts]) for name in ("arc_mm", "force_n"))
    spread = np.average((arcs - np.average(arcs, weights=weights)) ** 2, weights=weights)
    assert measures.Conformity(6.0).value(solution) == pytest.approx(np.sqrt(12.0 * spread))
    strains = [max(place.to_dict()["max_strain"].values()) for place in solution]
    assert measures.MaxStrain(6.0).value(solution) == max(strains) and measures.MaxStrain(5.0).value(solution) == max(strains[:3])
    # Pushing the object a little against its force makes that force larger by the stiffness.
    along = last.force_n / last.force_magnitude_n
    moved = firm.with_values({f"object.centre_mm.{axis}": c - 1e-4 * along[axis] for axis, c in enumerate((41.0, 45.0))})
    change = (fre.solve(moved)[0].force_n - last.force_n) @ along / 1e-4
    assert measures.Stiffness(6.0).value(solution) == pytest.approx(change, rel=1e-3)
    # Two beams of 80 and 84.8 mm, 2 mm thick, and seven lamellae, 20 mm wide, of 1.2 g/cm³.
    lamellae = sum(28.0 * (1.0 - height / 80.0) for height in range(9, 64, 9)) * 3.0
    assert measures.Mass(1200.0).value(solution) == pytest.approx((80.0 * 2.0 + np.hypot(28.0, 80.0) * 2.0 + lamellae) * 20.0 * 1.2e-3)
    assert measures.Snap(6.0).value(solution) == 6.0
    far = fre.solve(firm.with_motion(fre.Rotation([0.0, 20.0, 40.0])))
    first = far[-1].first_branch
    assert first is not None and measures.Snap(40.0).value(far) == first.snap_between_deg[0] < 40.0
    with pytest.raises(measures.Unreached):
        measures.Force(5.0).value(fre.solve(fre.Case("preset:ladder-80", fre.Circle(200.0, (41.0, 45.0)), fre.Rotation([5.0]))))


def test_a_search_keeps_limits_and_goes_on_where_it_was(firm: fre.Case, tmp_path: pathlib.Path) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    limits = [(measures.MaxStrain(at=6.0), 0.0, 0.06)]

    def problem() -> Problem:
        return Problem(firm, vary, measures.Force(at=6.0), maximise=True, limits=limits, options=REDUCED)

    log = tmp_path / "search.json"
    told: list[tuple[int, int]] = []
    best = optimise(problem(), starts=2, most=15, log=log, progress=lambda done, total, goal: told.append((done, total)))
    assert told == [(1, 2), (2, 2)]
    kept = best.problem.margins(best.x)
    assert kept.min() > -1e-6 and best.gain > 0.0
    # Nowhere in the bounds is a better one.
    for x in np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, 5)]), axis=-1).reshape(-1, 2):
        if best.problem.margins(x).min() >= 0.0:
            assert best.problem.value(x) >= best.problem.value(best.x) - 1e-3
    again = problem()
    same = optimise(again, starts=2, most=15, log=log)
    assert same.x.tolist() == best.x.tolist() and again.evaluations < 5
    assert "kept" in best.report() and all("<svg" in (picture or "") for picture in best.pictures())
    other = Problem(firm, vary, measures.Force(at=5.0), options=REDUCED)
    with pytest.raises(FileExistsError, match="another problem"):
        optimise(other, log=log)


def test_a_front_of_two_goals_falls(firm: fre.Case) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    problem = Problem(firm, vary, measures.Force(at=6.0), maximise=True, options=REDUCED)
    front = list(pareto(problem, measures.MaxStrain(at=6.0), [0.058, 0.060, 0.062], starts=1))
    forces = [-one.problem.value(one.x) for _, one in front]
    assert forces == sorted(forces) and forces[-1] > forces[0]


def test_what_cannot_be_varied_is_refused(firm: fre.Case) -> None:
    with pytest.raises(fre.CaseError, match="at least one key"):
        Problem(firm, {}, measures.Force(6.0))
    with pytest.raises(fre.CaseError, match="must be less"):
        Problem(firm, {"object.radius_mm": (40.0, 40.0)}, measures.Force(6.0))
    with pytest.raises(fre.CaseError) as error:
        Problem(firm, {"object.size": (30.0, 40.0)}, measures.Force(6.0))
    assert error.value.key == "object.size"
