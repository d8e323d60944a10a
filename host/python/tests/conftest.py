"""What the tests have in common."""

from __future__ import annotations

import os
import pathlib

import pytest

import fre


@pytest.fixture
def case() -> fre.Case:
    """A finger on a cylinder, from no contact to a firm one."""
    return fre.Case(
        fre.Finger.preset("ladder-80"),
        fre.Circle(radius_mm=40.0, centre_mm=(41.0, 45.0)),
        fre.Rotation([-2.0, 2.0, 4.0, 8.0]),
    )


@pytest.fixture
def program() -> str:
    """The command `fre`."""
    path = os.environ.get("FRE_PROGRAM")
    assert path and pathlib.Path(path).exists(), "FRE_PROGRAM names no program: run `cargo xtask test python`"
    return path


@pytest.fixture
def examples() -> pathlib.Path:
    """The repository's example cases."""
    return pathlib.Path(__file__).parents[3] / "examples"
