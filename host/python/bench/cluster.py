"""What a sweep on a Ray cluster of this machine costs: `python host/python/bench/cluster.py [ROWS]` with the wheel and the extra
`fre[ray]`. Prints

- rows per second with one and with two cores, and their ratio: of several runs taken in turn the fastest of each;
- what a task costs the one program that hands them out: its processor's time with many short tasks, less that with few long ones;
- for how much of the time that keeps it busy on larger clusters;
- its peak memory for ROWS rows (a million) over that of a program that has only joined the cluster.
"""

from __future__ import annotations

import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np
import ray

import fre
from fre import cluster

ANGLES = np.arange(1.0, 11.1, 1.0)
ROWS = 1_000_000
SCALED_ROWS = 44_000
"""Rows of a run that is compared with others."""
REPETITIONS = 3
SHORT_S, LONG_S = 0.1, 2.0
"""Lengths of tasks, of which the difference is taken."""


def joined(cores: int) -> None:
    ray.init(address="local", num_cpus=cores, include_dashboard=False, log_to_driver=False, logging_level="error")


def peak_mb() -> float:
    """Peak memory of this process, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def swept(cores: int, rows: int, task_s: float) -> dict[str, float]:
    """A sweep in this process, its workers being there already."""
    joined(cores)
    case = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation(ANGLES))
    options = fre.Options(elements="reduced")
    with tempfile.TemporaryDirectory() as folder:
        # Twenty short tasks: every core has its worker, which has loaded all that it needs.
        few = {"object.radius_mm": np.linspace(36.0, 44.0, 2000)}
        cluster.sweep(case, few, pathlib.Path(folder) / "first.parquet", options=options, task_s=0.05)
        tasks: list[int] = []
        begin, before = time.perf_counter(), time.process_time()
        written = cluster.sweep(
            case,
            {"object.radius_mm": np.linspace(36.0, 44.0, -(-rows // len(ANGLES)))},
            pathlib.Path(folder) / "sweep.parquet",
            options=options,
            task_s=task_s,
            progress=lambda done, points: tasks.append(done),
        )
        seconds, own = time.perf_counter() - begin, time.process_time() - before
    return {"rows": written, "seconds": seconds, "own": own, "tasks": len(tasks) - 1, "peak_mb": peak_mb()}


def in_a_process(*words: object) -> dict[str, Any]:
    """The same in a process of its own."""
    program = [sys.executable, __file__, *map(str, words)]
    found: dict[str, Any] = json.loads(subprocess.run(program, check=True, capture_output=True, text=True).stdout)
    return found


def main() -> None:
    match sys.argv[1:]:
        case ["empty"]:
            joined(2)
            ray.get(ray.remote(lambda: 0).remote())
            print(json.dumps({"peak_mb": peak_mb()}))
            return
        case ["sweep", *words]:
            of_cores, of_rows, length_s = words
            print(json.dumps(swept(int(of_cores), int(of_rows), float(length_s))))
            return
        case [word]:
            all_rows = int(word)
        case _:
            all_rows = ROWS
    rates: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(REPETITIONS):
        for cores, found in rates.items():
            one = in_a_process("sweep", cores, SCALED_ROWS * cores, LONG_S)
            found.append(one["rows"] / one["seconds"])
    one_core, two_cores = max(rates[1]), max(rates[2])
    print(f"one core {one_core:,.0f} rows/s, two cores {two_cores:,.0f} rows/s: {two_cores / one_core:.2f} times as many")
    costs = []
    for _ in range(REPETITIONS):
        short, long = (in_a_process("sweep", 2, SCALED_ROWS, task_s) for task_s in (SHORT_S, LONG_S))
        costs.append((short["own"] - long["own"]) / (short["tasks"] - long["tasks"]))
    cost = float(np.median(costs))
    print(f"a task costs {1e3 * cost:.2f} ms of the program that hands it out (from {1e3 * min(costs):.2f} to {1e3 * max(costs):.2f})")
    for cores in (64, 256, 1000):
        busy = ", ".join(f"{cores * cost / task_s:.2f} with tasks of {task_s:g} s" for task_s in (2.0, 5.0, 10.0))
        print(f"{cores} cores keep it busy for {busy}")
    whole, empty = in_a_process("sweep", 2, all_rows, LONG_S), in_a_process("empty")
    print(f"{whole['rows']:,} rows: peak {whole['peak_mb']:.0f} MB, {whole['peak_mb'] - empty['peak_mb']:.0f} MB over an empty program")


if __name__ == "__main__":
    main()
