"""The notebooks run from the first cell to the last."""

from __future__ import annotations

import os
import pathlib
import sys
from typing import Any

import nbformat as _nbformat
import pytest
from nbclient import NotebookClient

# Its own types are not complete.
nbformat: Any = _nbformat

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "notebooks"
# Keeps what the notebooks show, for whoever wants to look at it.
KEEP = os.environ.get("FRE_KEEP_NOTEBOOKS")


def test_there_are_four() -> None:
    names = sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb"))
    assert names == ["calibrate", "compare", "optimise", "solve"]


@pytest.mark.parametrize("name", ["calibrate", "compare", "optimise", "solve"])
def test_a_notebook_runs_and_shows_pictures(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # The kernel is this Python, whatever kernels are installed.
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    nbformat.validate(notebook)
    assert all(not cell.get("outputs") for cell in notebook.cells), "notebooks are kept without their outputs"
    notebook.metadata.kernelspec.name = "python3"
    client = NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(NOTEBOOKS)}})
    client.create_kernel_manager()
    kernel: Any = client.km
    kernel.kernel_spec.argv[0] = sys.executable
    client.execute()
    data = [output.data for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    pictures = [one for one in data if "image/svg+xml" in one or "image/png" in one]
    assert pictures, "no picture"
    if KEEP:
        nbformat.write(notebook, pathlib.Path(KEEP) / f"{name}.ipynb")
