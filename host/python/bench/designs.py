"""Three design problems, from the preset to the optimum: `python host/python/bench/designs.py`. Prints before and after of each; with
CalculiX installed also how far finite elements agree with the optimum."""

from __future__ import annotations

import shutil
import time

import numpy as np

import fre
from fre import measures
from fre.optimisation import Optimum, Problem, optimise

OPTIONS = fre.Options(elements="reduced")
# What a designer is free in: thicknesses and where the back beam is.
VARY = {
    "finger.front.thickness_mm": (1.0, 3.0),
    "finger.back.thickness_mm": (1.0, 3.0),
    "finger.hinge.thickness_mm": (0.5, 1.4),
    "finger.back.base_mm.0": (-36.0, -24.0),
}


def held(height_mm: float) -> fre.Case:
    """The preset with shorter hinges, which leave room for thicker beams."""
    finger = fre.Finger.preset("fea-80").with_values({"hinge.length_mm": 1.2})
    return fre.Case(finger, fre.Circle(40.0, (41.0, height_mm)), fre.Rotation([6.0]))


def constant_force() -> Problem:
    """As constant a force as possible over 4 to 10°, of 3 N or more."""
    limits = [(measures.MeanForce(4.0, 10.0, 7), 3.0, np.inf)]
    return Problem(held(60.0), VARY, measures.ForceVariation(4.0, 10.0, 7), limits=limits, options=OPTIONS)


def stiffest() -> Problem:
    """The stiffest finger whose strain at 8° is below 10 %."""
    limits = [(measures.MaxStrain(8.0), 0.0, 0.10)]
    return Problem(held(45.0), VARY, measures.Stiffness(8.0), maximise=True, limits=limits, options=OPTIONS)


def conforming() -> Problem:
    """A force that is spread far at 10°, on a cylinder of 40 mm as on one of 80 mm."""
    small = {"object.radius_mm": 20.0, "object.centre_mm.0": 21.0}
    goal = measures.Conformity(10.0)
    return Problem(held(45.0), VARY, goal, maximise=True, objects=[small], options=OPTIONS)


def agrees(best: Optimum, angle_deg: float) -> str:
    if not shutil.which("ccx"):
        return "CalculiX is not installed"
    comparison = fre.compare(best.case.with_motion(fre.Rotation([angle_deg])), fea=True)
    return ", ".join(f"{row.place}°: {row.error_percent:+.2f} %" for row in comparison.rows)


def main() -> None:
    for problem, angle in ((constant_force(), 8.0), (stiffest(), 8.0), (conforming(), 10.0)):
        begin = time.perf_counter()
        best = optimise(problem, starts=4, most=30)
        seconds = time.perf_counter() - begin
        print(best.report())
        print(f"{problem.evaluations} solved cases in {seconds:.1f} s, {problem.evaluations / seconds:.0f} per second")
        print(f"finite elements at the optimum: {agrees(best, angle)}\n")


if __name__ == "__main__":
    main()
