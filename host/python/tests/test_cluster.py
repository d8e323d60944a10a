"""A Ray cluster of several nodes on this machine."""

from __future__ import annotations

import os
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas
import pytest

import fre

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
# Nodes are reached by the loopback address: a machine need not reach itself by any other.
os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"
ray = pytest.importorskip("ray")
from ray.cluster_utils import Cluster  # noqa: E402

from fre import cluster as many  # noqa: E402
from fre import measures  # noqa: E402
from fre.optimisation import Problem, optimise  # noqa: E402

RADII = np.linspace(35.0, 45.0, 41)
REDUCED = fre.Options(elements="reduced")
ARGUMENTS: dict[str, Any] = {"node_ip_address": "127.0.0.1", "object_store_memory": 80 << 20, "include_dashboard": False}


@pytest.fixture(scope="module")
def nodes() -> Iterator[Any]:
    """A head without cores, and two nodes of one core each."""
    cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, **ARGUMENTS})
    for _ in range(2):
        cluster.add_node(num_cpus=1, **{key: value for key, value in ARGUMENTS.items() if key != "include_dashboard"})
    ray.init(address=cluster.address, log_to_driver=False, logging_level="error")
    cluster.wait_for_nodes()
    yield cluster
    ray.shutdown()
    cluster.shutdown()


def timeless(table: Any) -> Any:
    return table.drop(columns="elapsed_us")


def test_a_cluster_has_the_numbers_of_one_machine_also_when_a_node_is_killed(
    nodes: Any, case: fre.Case, tmp_path: pathlib.Path
) -> None:
    out = tmp_path / "sweep.parquet"
    killed: list[int] = []

    def kill(done: int, points: int) -> None:
        if done > 4 and not killed:
            killed.append(done)
            nodes.add_node(num_cpus=1, node_ip_address="127.0.0.1", object_store_memory=80 << 20)
            nodes.remove_node(nodes.list_all_nodes()[1], allow_graceful=False)

    rows = many.sweep(case, {"object.radius_mm": RADII}, out, task_s=0.05, shapes=True, progress=kill)
    assert killed and rows == 4 * len(RADII)
    here = tmp_path / "here.csv"
    fre.sweep(case, {"object.radius_mm": RADII}, out=here, parquet=tmp_path / "here.parquet", shapes=True)
    expected, found = pandas.read_parquet(tmp_path / "here.parquet"), pandas.read_parquet(out)
    pandas.testing.assert_frame_equal(timeless(found), timeless(expected), check_exact=True)
    assert not (tmp_path / "sweep.parquet.parts").exists()
    # What is there is not solved again, and another sweep does not take its place.
    assert many.sweep(case, {"object.radius_mm": RADII}, out, shapes=True) == rows
    with pytest.raises(FileExistsError, match="is not this sweep"):
        many.sweep(case, {"object.radius_mm": RADII[:3]}, out)
    with pytest.raises(fre.CaseError, match="at object.radius_mm=-1"):
        many.sweep(case, {"object.radius_mm": [-1.0, 40.0]}, tmp_path / "bad.parquet")


DRIVER = """
import json, pathlib, sys
import numpy as np, ray
import fre
from fre import cluster
ray.init(address="local", num_cpus=1, include_dashboard=False, log_to_driver=False, logging_level="error", object_store_memory=80 << 20,
         _node_ip_address="127.0.0.1")
case = fre.Case.read(sys.argv[1])
told = lambda done, points: print(done, points, flush=True)
print("rows", cluster.sweep(case, {"object.radius_mm": np.linspace(35.0, 45.0, 41)}, sys.argv[2], task_s=0.05, progress=told))
"""


def test_a_killed_program_goes_on_where_it_was(case: fre.Case, tmp_path: pathlib.Path) -> None:
    file, out = tmp_path / "case.toml", tmp_path / "sweep.parquet"
    file.write_text(case.toml())

    def start() -> subprocess.Popen[str]:
        words = [sys.executable, "-c", DRIVER, str(file), str(out)]
        return subprocess.Popen(words, stdout=subprocess.PIPE, text=True, start_new_session=True)

    first = start()
    assert first.stdout is not None
    for line in first.stdout:
        if int(line.split()[0]) >= 8:
            break
    os.killpg(first.pid, signal.SIGKILL)
    first.wait()
    parts = list((tmp_path / "sweep.parquet.parts").glob("points-*.parquet"))
    kept = sum(len(many._points(path)) for path in parts)
    assert 8 <= kept < 41 and not out.exists()
    second = start()
    output, _ = second.communicate(timeout=240)
    lines = output.split("\n")
    assert second.returncode == 0 and lines[0] == f"{kept} 41" and lines[-2] == f"rows {4 * 41}"
    assert pandas.read_parquet(out)["row"].tolist() == list(range(4 * 41))


def test_a_refused_value_leaves_nothing_behind(nodes: Any, case: fre.Case, tmp_path: pathlib.Path) -> None:
    out = tmp_path / "rows.parquet"
    with pytest.raises(fre.CaseError):
        many.sweep(case, {"object.radius_mm": [39.0, -1.0]}, out, angles_deg=[4.0])
    assert many.sweep(case, {"object.radius_mm": [39.0, 40.0]}, out, angles_deg=[4.0]) == 2
    with pytest.raises(fre.CaseError, match="samples = 0"):
        many.bootstrap(tmp_path / "none.csv", case, samples=0)


def test_a_bootstrap_scatters_as_the_noise_does(nodes: Any, case: fre.Case, tmp_path: pathlib.Path) -> None:
    angles = np.arange(2.0, 10.01, 0.25)
    forces = fre.solve(case.with_motion(fre.Rotation(angles))).force_magnitude_n
    forces = forces + np.random.default_rng(3).normal(0.0, 0.05, len(forces))
    csv = tmp_path / "forces.csv"
    csv.write_text("motor_angle_deg,force_n\n" + "".join(f"{a},{f}\n" for a, f in zip(angles, forces)))
    reduced = fre.Options(elements="reduced")
    found = many.bootstrap(csv, case, ["youngs-modulus"], samples=24, noise=fre.Noise(force_sd_n=0.05), options=reduced)
    fit = fre.calibrate(csv, case, ["youngs-modulus"], fre.Noise(force_sd_n=0.05), options=reduced)
    expected = fit.parameter("youngs-modulus")["standard_deviation"]
    assert found.shape == (24, 1) and 0.4 * expected < found.std() < 2.5 * expected
    again = many.bootstrap(csv, case, ["youngs-modulus"], samples=24, noise=fre.Noise(force_sd_n=0.05), options=reduced)
    np.testing.assert_array_equal(found, again)


def measured(case: fre.Case, opening: float) -> list[tuple[float, float]]:
    """Angles and forces of a finger that closes and opens again. While it opens, its forces are the model's times a factor."""
    angles = np.arange(2.0, 8.01, 0.5)
    forces = fre.solve(case.with_motion(fre.Rotation(angles)), REDUCED).force_magnitude_n
    closing = list(zip(angles.tolist(), forces.tolist()))
    return [*closing, *((angle, opening * force) for angle, force in closing[-2::-1])]


def test_a_bootstrap_fits_what_a_calibration_fits(nodes: Any, case: fre.Case, tmp_path: pathlib.Path) -> None:
    rows = measured(case, opening=0.8)
    csv = tmp_path / "forces.csv"
    csv.write_text("motor_angle_deg,force_n\n" + "".join(f"{angle},{force}\n" for angle, force in rows))
    fit = ["youngs-modulus"]
    for both_ways in (False, True):
        expected = fre.calibrate(csv, case, fit, both_ways=both_ways, options=REDUCED).parameter(fit[0])
        found = many.bootstrap(csv, case, fit, samples=4, both_ways=both_ways, options=REDUCED)
        assert abs(found.mean() - expected["value"]) < 0.05 * expected["value"], (both_ways, found, expected)
    closing = many.bootstrap(csv, case, fit, samples=4, options=REDUCED)
    # Without noise every drawn reading says the same.
    assert np.ptp(closing) < 1e-3 * closing.mean() and found.mean() < 0.97 * closing.mean()
    # The same file as spreadsheets and people write it.
    lines = ["# measured on Monday", "", "sep=;", "motor_angle_deg;force_n", "# closing"]
    lines += [f"{angle};{force}".replace(".", ",") for angle, force in rows]
    other = tmp_path / "other.csv"
    other.write_bytes("\r\n".join(lines).encode("utf-16"))
    np.testing.assert_array_equal(many.bootstrap(other, case, fit, samples=4, options=REDUCED), closing)


def test_a_bootstrap_refuses_a_material_with_memory(nodes: Any, case: fre.Case, tmp_path: pathlib.Path) -> None:
    csv = tmp_path / "forces.csv"
    rows = "".join(f"{angle},{force},{time}\n" for time, (angle, force) in enumerate(measured(case, opening=1.0)))
    csv.write_text("motor_angle_deg,force_n,time_s\n" + rows)
    slow = fre.Case(case.finger.with_values({"material.prony": [[0.2, 5.0]]}), case.object, case.motion)
    assert fre.calibrate(csv, slow, ["youngs-modulus"], options=REDUCED).converged
    with pytest.raises(fre.CaseError, match="a bootstrap draws each reading without regard to the others") as error:
        many.bootstrap(csv, slow, ["youngs-modulus"], samples=2, options=REDUCED)
    assert error.value.key == "finger.material.prony"


def test_a_search_is_that_of_one_machine(nodes: Any, case: fre.Case, tmp_path: pathlib.Path) -> None:
    vary = {"finger.front.thickness_mm": (1.5, 2.6), "finger.back.thickness_mm": (1.5, 2.6)}
    reduced = fre.Options(elements="reduced")
    problem = Problem(case, vary, measures.Force(at=6.0), maximise=True, limits=[(measures.MaxStrain(6.0), 0.0, 0.06)], options=reduced)
    here = optimise(problem, starts=4, most=15)
    folder = tmp_path / "search"
    there = many.optimise(problem, starts=4, most=15, folder=folder)
    assert there.tries == here.tries
    # One start is missing: it alone is searched again.
    (folder / "start-000002.json").unlink()
    told: list[int] = []
    again = many.optimise(problem, starts=4, most=15, folder=folder, progress=lambda done, starts: told.append(done))
    assert again.tries == here.tries and told == [3, 4]
    with pytest.raises(FileExistsError, match="another search"):
        many.optimise(problem, starts=4, most=16, folder=folder)


def test_few_tasks_are_under_way_at_once_and_errors_are_raised_here(nodes: Any) -> None:
    # A node that was killed counts until its silence is noticed.
    deadline = time.monotonic() + 120.0
    while (cores := ray.cluster_resources()["CPU"]) > 2.0:
        assert time.monotonic() < deadline, f"{cores} cores"
        time.sleep(0.2)
    taken: list[int] = []

    def items() -> Iterator[int]:
        for number in range(60):
            taken.append(number)
            yield number

    def square(number: int) -> int:
        time.sleep(0.001)
        return number * number

    most = 0
    for count, (number, result) in enumerate(many.each(square, items())):
        assert result == number * number
        most = max(most, len(taken) - count)
    assert len(taken) == 60 and most <= 3 * 2

    def fail(number: int) -> int:
        raise ValueError(f"{number} is no good")

    with pytest.raises(ValueError, match="7 is no good"):
        list(many.each(fail, [7]))
