"""Ctrl-C ends long work at once."""

from __future__ import annotations

import os
import pathlib
import signal
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

import fre

ANGLES = np.tile([2.0, 8.0], 5_000)


def interrupted(work: Callable[[], object]) -> float:
    """How long after a SIGINT the work ends, s."""
    sent: list[float] = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        work()
    return time.monotonic() - sent[0]


def test_an_interrupt_ends_a_solution(case: fre.Case) -> None:
    long = case.with_motion(fre.Rotation(ANGLES))
    assert interrupted(lambda: fre.solve(long)) < 2.0


def test_an_interrupt_ends_a_batch(case: fre.Case) -> None:
    radii = np.linspace(35.0, 45.0, 5_000)
    assert interrupted(lambda: fre.solve_many(case, {"object.radius_mm": radii})) < 2.0
    # The next batch is as any.
    assert len(fre.solve_many(case, {"object.radius_mm": radii[:10]})) == 10


def test_an_interrupt_ends_a_comparison(case: fre.Case, tmp_path: pathlib.Path) -> None:
    csv = tmp_path / "forces.csv"
    csv.write_text("motor_angle_deg,force_n\n" + "".join(f"{angle},2.0\n" for angle in ANGLES))
    assert interrupted(lambda: fre.compare(case, csv, order="file")) < 2.0


def test_an_interrupt_ends_a_calibration(case: fre.Case, tmp_path: pathlib.Path) -> None:
    csv = tmp_path / "forces.csv"
    csv.write_text("motor_angle_deg,force_n\n" + "".join(f"{angle},2.0\n" for angle in np.linspace(2.0, 8.0, 200)))
    parameters = ["youngs-modulus", "zero", "object-x", "object-y", "friction"]
    assert interrupted(lambda: fre.calibrate(csv, case, parameters)) < 2.0
