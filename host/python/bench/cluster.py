"""What a sweep on a Ray cluster of this machine costs: `python host/python/bench/cluster.py [ROWS [CORES]]` with the wheel and the extra
`fre[ray]`. Prints rows per second, the processor time of the program that hands out the tasks, and its peak memory over that of a
program that has only joined the cluster."""

from __future__ import annotations

import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np
import ray

import fre
from fre import cluster

ANGLES = np.arange(1.0, 11.1, 1.0)


def joined(cores: int) -> None:
    ray.init(address="local", num_cpus=cores, include_dashboard=False, log_to_driver=False, logging_level="error")


def peak_mb() -> float:
    """Peak memory of this process, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def empty_mb(cores: int) -> float:
    """Peak memory of a program that has joined a cluster and does nothing."""
    program = [sys.executable, __file__, "empty", str(cores)]
    return float(subprocess.run(program, check=True, capture_output=True, text=True).stdout)


def main() -> None:
    words = sys.argv[1:]
    if words[:1] == ["empty"]:
        joined(int(words[1]))
        ray.get(ray.remote(lambda: 0).remote())
        print(peak_mb())
        return
    rows, cores = int(words[0]) if words else 1_000_000, int(words[1]) if len(words) > 1 else 2
    empty = empty_mb(cores)
    joined(cores)
    case = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation(ANGLES))
    points = -(-rows // len(ANGLES))
    with tempfile.TemporaryDirectory() as folder:
        begin, before = time.perf_counter(), time.process_time()
        out = pathlib.Path(folder) / "sweep.parquet"
        vary = {"object.radius_mm": np.linspace(36.0, 44.0, points)}
        written = cluster.sweep(case, vary, out, options=fre.Options(elements="reduced"))
        seconds, own = time.perf_counter() - begin, time.process_time() - before
    print(f"{written} rows on {cores} cores in {seconds:.1f} s: {written / seconds:.0f} rows/s")
    print(f"the program itself: {own:.1f} s of its processor, peak {peak_mb():.0f} MB, {peak_mb() - empty:.0f} MB over an empty one")


if __name__ == "__main__":
    main()
