"""What a batch costs in Python over what the solver alone costs, in one run: `python host/python/bench/batch.py` with the wheel of
a release build. Prints the seconds per case of both, and their ratio: the least of several repetitions of each, taken in turn."""

from __future__ import annotations

import time

import numpy as np

import fre
from fre import _core

CASES = 200
REPETITIONS = 7


def main() -> None:
    case = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation(np.arange(0.0, 11.1, 1.0)))
    radii = np.linspace(36.0, 44.0, CASES)
    for elements in ("reduced", "fine"):
        for threads in (1, 0):
            options = fre.Options(elements=elements)
            python, rust = [], []
            for _ in range(REPETITIONS):
                begin = time.perf_counter()
                fre.solve_many(case, {"object.radius_mm": radii}, options, threads=threads)
                python.append((time.perf_counter() - begin) / CASES)
                rust.append(_core.time_many(case._case, ["object.radius_mm"], radii[:, None], options, threads) / CASES)
            least, own = min(python), min(rust)
            where = "one core" if threads == 1 else "all cores"
            print(f"{elements:8} {where:9}  {1e3 * least:8.3f} ms a case  {1e3 * own:8.3f} ms the solver  ratio {least / own:.3f}")


if __name__ == "__main__":
    main()
