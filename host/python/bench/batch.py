"""What a batch costs in Python over what the solver alone costs, in one run: `python host/python/bench/batch.py` with the wheel of
a release build. Prints both per case and their ratio: the least of several repetitions of each, taken in turn. On one core these are
times of the processor, which other programs do not lengthen, and the exit status is 1 if the ratio is above 1.1; on all cores they
are times of the clock.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import fre
from fre import _core

CASES = 100
REPETITIONS = 9
MOST = 1.1
KEY = "object.radius_mm"


def seconds(clock: Callable[[], float], work: Callable[[], object]) -> float:
    """Time of a work and of the removal of its result."""
    begin = clock()
    work()
    return clock() - begin


def main() -> None:
    case = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation(np.arange(0.0, 11.1, 1.0)))
    radii = np.linspace(36.0, 44.0, CASES)
    worst = 0.0
    for elements in ("reduced", "fine"):
        options = fre.Options(elements=elements)
        for threads in (1, 0):
            clock = time.process_time if threads == 1 else time.perf_counter
            made = _core.Made(case._case, [KEY], radii[:, None], options, threads)
            many, solver = [], []
            for _ in range(REPETITIONS):
                many.append(seconds(clock, lambda: fre.solve_many(case, {KEY: radii}, options, threads=threads)))
                solver.append(seconds(clock, made.solve))
            whole, own = min(many) / CASES, min(solver) / CASES
            if threads == 1:
                worst = max(worst, whole / own)
            where = "one core" if threads == 1 else "all cores"
            print(f"{elements:8} {where:9}  {1e3 * whole:8.3f} ms a case  {1e3 * own:8.3f} ms the solver  ratio {whole / own:.3f}")
    if worst > MOST:
        sys.exit(f"on one core a case costs {worst:.3f} times what the solver takes: more than {MOST}")


if __name__ == "__main__":
    main()
