"""The microcontroller's estimator."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest

import fre

COUNT = math.tau / 4096.0


def test_the_estimate_is_that_of_the_crates_own_example(case: fre.Case) -> None:
    estimator = fre.Estimator(case)
    assert estimator.update(-COUNT, 0.002).status is fre.Status.no_contact
    for tick in range(69):
        estimate = estimator.update(tick * COUNT, 0.002)
    estimate = estimator.update(68 * COUNT, 0.002)
    assert estimate.status is fre.Status.converged and estimate.age == 0
    assert abs(estimate.force_magnitude_n - 3.78) < 0.01
    # Single precision, as on the microcontroller.
    for value in estimate[1:14]:
        assert float(np.float32(value)) == value


def test_it_agrees_with_the_solver(case: fre.Case) -> None:
    estimator = fre.Estimator(case)
    angles = np.radians(np.arange(-2.0, 8.01, 0.1))
    for angle in angles:
        estimate = estimator.update(angle)
    force = fre.solve(case)[-1].force_magnitude_n
    assert abs(estimate.force_magnitude_n / force - 1.0) < 2e-3


def test_friction_makes_the_force_depend_on_the_way(case: fre.Case) -> None:
    rough = case.with_values({"object.friction": 0.6})
    estimator = fre.Estimator(rough)
    for angle in np.radians(np.arange(-2.0, 8.01, 0.04)):
        estimate = estimator.update(angle)
    assert estimate.force_interval_n is not None
    low, high = estimate.force_interval_n
    assert low <= estimate.force_magnitude_n <= high and high - low < 0.02 * high
    angle = estimate.motor_angle_rad
    solved = fre.solve(fre.Case(rough.finger, rough.object, fre.Rotation([math.degrees(angle)])))[-1]
    assert abs(estimate.force_magnitude_n / solved.force_magnitude_n - 1.0) < 0.01
    # Set down anew on the same object: how it came there is not known.
    blind = fre.Estimator(rough)
    for _ in range(60):
        estimate = blind.update(angle)
    assert estimate.force_interval_n is not None and estimate.torque_interval_nmm is not None
    low, high = estimate.force_interval_n
    assert high - low > 0.1 * high and low < solved.force_magnitude_n <= 1.01 * high
    assert fre.Estimator(case).update(angle).force_interval_n is None


def test_two_estimators_give_the_same_bits_and_pickles_begin_anew(case: fre.Case) -> None:
    one = fre.Estimator(case)
    other = pickle.loads(pickle.dumps(one))
    for tick in range(-20, 80):
        assert one.update(tick * COUNT) == other.update(tick * COUNT)
    estimate = one.update(0.1)
    assert pickle.loads(pickle.dumps(estimate)) == estimate


def test_what_is_no_angle_or_time_is_refused(case: fre.Case) -> None:
    estimator = fre.Estimator(case)
    with pytest.raises(fre.CaseError) as error:
        estimator.update(math.nan)
    assert error.value.key == "angle_rad"
    for dt in (-1.0, math.nan, math.inf):
        with pytest.raises(fre.CaseError) as error:
            estimator.update(0.0, dt)
        assert error.value.key == "dt_s"
    assert estimator.update(3.0).status is fre.Status.out_of_range
    jaws = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Translation((1.0, 0.0), [1.0]))
    with pytest.raises(fre.CaseError) as error:
        fre.Estimator(jaws)
    assert error.value.key == "motion.direction"


def test_a_material_with_memory_fades_with_time() -> None:
    finger = fre.Finger.preset("ladder-80").with_values({"material.prony": [[0.2, 1.0], [0.2, 50.0]]})
    case = fre.Case(finger, fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([6.0]))
    estimator = fre.Estimator(case)
    for tick in range(-20, 60):
        sudden = estimator.update(tick * COUNT)
    assert sudden.force_magnitude_n == pytest.approx(estimator.update(59 * COUNT).force_magnitude_n)
    second = estimator.update(59 * COUNT, 1.0)
    left = 1.0 - 0.2 * (1.0 - math.exp(-1.0)) - 0.2 * (1.0 - math.exp(-0.02))
    assert second.force_magnitude_n / sudden.force_magnitude_n == pytest.approx(left, rel=1e-3)
    assert second.torque_nmm / sudden.torque_nmm == pytest.approx(left, rel=1e-3)
    # One that begins on the object does not know for how long it has been there.
    late = fre.Estimator(case)
    for _ in range(50):
        found = late.update(59 * COUNT, 0.002)
    assert found.force_interval_n is not None
    low, high = found.force_interval_n
    assert low == pytest.approx(0.6 * sudden.force_magnitude_n, rel=0.02) and high > 0.95 * sudden.force_magnitude_n


def test_it_has_the_room_of_a_board_also_in_a_thread_with_a_small_stack() -> None:
    twelve = fre.Finger.preset("ladder-80").with_values({"lamellae.heights_mm": [5.0 * k for k in range(1, 13)]})
    ribs = fre.Finger.preset("umi").with_values({"motor.axis_mm": [-18.0, -20.0]})
    circle = fre.Circle(40.0, (41.0, 45.0))
    cases = [fre.Case(finger, circle, fre.Rotation([math.degrees(68 * COUNT)])) for finger in (twelve, ribs)]
    found: list[fre.Estimate] = []

    def follow() -> None:
        for case in cases:
            estimator = fre.Estimator(case)
            found.append([estimator.update(tick * COUNT) for tick in range(-20, 69)][-1])

    before = threading.stack_size(512 * 1024)
    try:
        thread = threading.Thread(target=follow)
        thread.start()
        thread.join()
    finally:
        threading.stack_size(before)
    for case, estimate in zip(cases, found, strict=True):
        assert estimate.status is fre.Status.converged
        assert estimate.force_magnitude_n == pytest.approx(fre.solve(case)[0].force_magnitude_n, rel=0.02)


MILLION = """
import math, resource, sys
import fre

case = fre.Case("preset:ladder-80", fre.Circle(radius_mm=40.0, centre_mm=(41.0, 45.0)), fre.Rotation([8.0]))
estimator = fre.Estimator(case)
count = math.tau / 4096.0

def run(ticks):
    for tick in range(ticks):
        estimator.update((60 + tick % 2) * count)

for tick in range(80):
    estimator.update(tick * count)
run(20_000)
before, blocks = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, sys.getallocatedblocks()
run(1_000_000)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, sys.getallocatedblocks() - blocks)
"""


def test_a_million_estimates_take_no_memory() -> None:
    # In a process of its own: what else a test runner does meanwhile is not counted.
    run = subprocess.run([sys.executable, "-c", MILLION], capture_output=True, text=True, check=True)
    grown, blocks = (int(word) for word in run.stdout.split())
    # Kilobytes of the peak, and Python's own allocations: a single byte kept of each estimate would be a thousand kilobytes.
    assert grown <= 256 and blocks < 100
