"""The package says its types, and they are true."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(__file__).parents[1]


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, cwd=FOLDER / "tests")


def test_mypy_finds_nothing_in_the_package_as_it_is_installed() -> None:
    spec = importlib.util.find_spec("fre")
    assert spec is not None and spec.origin is not None
    folder = pathlib.Path(spec.origin).parent
    assert (folder / "py.typed").exists() and (folder / "_core.pyi").exists()
    found = run("mypy", "--config-file", str(FOLDER / "pyproject.toml"), "-p", "fre")
    assert found.returncode == 0, found.stdout + found.stderr


def test_mypy_finds_nothing_in_these_tests() -> None:
    found = run("mypy", "--config-file", str(FOLDER / "pyproject.toml"), ".")
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_stub_says_what_the_module_has() -> None:
    found = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "fre._core"],
        capture_output=True,
        text=True,
        env={**os.environ, "MYPYPATH": ""},
    )
    assert found.returncode == 0, found.stdout + found.stderr
