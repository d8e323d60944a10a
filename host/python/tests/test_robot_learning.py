"""The examples for robot learning, on the simulated servo. An arm is anything that observes as LeRobot's robots do."""

from __future__ import annotations

import csv
import importlib.util
import json
import math
import pathlib
import subprocess
import sys
import time
from types import ModuleType
from typing import Any

import pytest

import fre
from test_live import PATIENCE_S, bus_port, case_file, folder, servo  # noqa: F401  (fixtures)


def example(examples: pathlib.Path, name: str) -> ModuleType:
    """An example as a module."""
    spec = importlib.util.spec_from_file_location(name, examples / "robot-learning" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Arm:
    """A follower arm."""

    name = "follower"
    observation_features = {"shoulder.pos": float}

    def get_observation(self) -> dict[str, Any]:
        return {"shoulder.pos": 12.5}


def test_an_arm_observes_the_force_of_its_gripper(bus_port: str, case: fre.Case, examples: pathlib.Path) -> None:  # noqa: F811
    module = example(examples, "force_gripper")
    bus = fre.Bus(bus_port, case, {"finger.0.zero_counts": 2048, "rate_hz": 100})
    arm = module.ForceGripper(Arm(), bus)
    end = time.monotonic() + PATIENCE_S
    while not (seen := arm.get_observation())["gripper.trusted"]:
        assert time.monotonic() < end, seen
        time.sleep(0.01)
    assert seen.keys() == arm.observation_features.keys() and arm.name == "follower" and seen["shoulder.pos"] == 12.5
    # The load holds the servo where it starts, but for some of its play.
    expected = fre.solve(case.with_motion(fre.Rotation([5.0, 7.0]))).force_magnitude_n
    assert expected[0] < seen["gripper.force_n"] < expected[1]
    assert seen["gripper.status"] == 0.0 and math.isnan(seen["gripper.margin"])
    arm.close()
    # Nothing is read any more: what was read last must not stand for now.
    time.sleep(2 * module.STALE_S)
    late = arm.get_observation()
    assert math.isnan(late["gripper.force_n"]) and late["gripper.trusted"] == 0.0
    assert list(fre.Status)[int(late["gripper.status"])] is fre.Status.stale


def test_an_arm_observes_the_margin_of_a_grip_of_two_fingers(
    program: str, case: fre.Case, case_file: pathlib.Path, folder: pathlib.Path, examples: pathlib.Path  # noqa: F811
) -> None:
    module = example(examples, "force_gripper")
    friction = 0.5
    port = folder / "bus"
    process = servo(program, case_file, "--unix", str(port), "--id", "1,2", "--start-deg", "6")
    fingers: dict[str, object] = {"finger.0.servo_id": 1, "finger.1.servo_id": 2, "finger.1.side": "right"}
    zeros = {f"finger.{finger}.zero_counts": 2048 for finger in range(2)}
    rubbing = fre.Case(case.finger, fre.Circle(radius_mm=40.0, centre_mm=(41.0, 45.0), friction=friction), case.motion)
    arm = module.ForceGripper(Arm(), fre.Bus(f"unix:{port}", rubbing, {**fingers, **zeros, "rate_hz": 100}))
    end = time.monotonic() + PATIENCE_S
    while math.isnan((seen := arm.get_observation())["gripper.margin"]):
        assert time.monotonic() < end, seen
        time.sleep(0.01)
    # Mirror images press against each other: the fingers' plane and the way across it are borne by friction on both sides, and no
    # direction bears more than both forces within their cones.
    assert 0.5 * friction * seen["gripper.force_n"] < seen["gripper.margin"] <= 2.0 * seen["gripper.force_n"]
    arm.close()
    process.terminate()
    process.wait(10)


def test_the_example_prints_observations(
    bus_port: str, case_file: pathlib.Path, examples: pathlib.Path  # noqa: F811
) -> None:
    words = ["--bus", bus_port, "--case", str(case_file), "--set", "rate_hz=100", "--set", "finger.0.zero_counts=2048"]
    script = examples / "robot-learning" / "force_gripper.py"
    command = [sys.executable, str(script), *words, "--count", "5"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=PATIENCE_S)
    seen = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(seen) == 5 and any(observation["gripper.force_n"] > 1.0 for observation in seen)


def test_a_recording_gets_its_forces(
    program: str, bus_port: str, case: fre.Case, case_file: pathlib.Path, folder: pathlib.Path, examples: pathlib.Path  # noqa: F811
) -> None:
    # Positions of the simulated servo at the pace of a camera, and what the estimator said of them at once.
    bus = fre.Bus(bus_port, case, {"finger.0.zero_counts": 2048, "rate_hz": 100})
    reports: list[fre.Report] = []
    for report in bus.reports(timeout_s=PATIENCE_S):
        if report.status.is_trustworthy and report.age == 0:
            reports.append(report)
        if len(reports) == 120:
            break
    reports = reports[::3]
    recorded, labelled = folder / "episode.csv", folder / "labelled.csv"
    # The arm's own unit: thousandths of a turn.
    with recorded.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["episode", "timestamp", "observation.gripper.pos"])
        table.writerows([7, report.time_us * 1e-6, report.motor_angle_deg / 0.36] for report in reports)
    script = examples / "robot-learning" / "label_forces.py"
    words = [str(recorded), str(labelled), "--case", str(case_file), "--scale", "0.36", "--fre", program]
    subprocess.run([sys.executable, str(script), *words], check=True, timeout=PATIENCE_S)
    with labelled.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(reports) and all(row["episode"] == "7" for row in rows)
    assert all(row["gripper.trusted"] == "1" and row["gripper.status"] == "converged" for row in rows)
    # The bus estimates with the resolution of its own option, the label with the finest.
    for row, report in zip(rows, reports):
        force = report.force_magnitude_n
        assert abs(float(row["gripper.force_n"]) - force) < 0.02 * force, row
        assert float(row["gripper.force_std_n"]) > 0.0


def test_a_recording_that_cannot_be_labelled_says_why(
    program: str, case_file: pathlib.Path, examples: pathlib.Path  # noqa: F811
) -> None:
    module = example(examples, "label_forces")
    rows = [{"timestamp": "0.0", "observation.gripper.pos": "1"}, {"timestamp": "0.0", "observation.gripper.pos": "2"}]
    with pytest.raises(RuntimeError, match="positions.csv:3: time_s is 0; allowed is above 0, that of the line before"):
        module.label(rows, str(case_file), fre=program)
    # Far beyond what the finger can do: the force is not known, and no number stands for it.
    [free, wild] = module.label([rows[0], {"timestamp": "1", "observation.gripper.pos": "120"}], str(case_file), fre=program)
    assert (free["gripper.trusted"], wild["gripper.trusted"], wild["gripper.force_n"]) == ("1", "0", "")
    assert wild["gripper.status"] == "out-of-range"
