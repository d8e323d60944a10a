"""The Python code that the book shows runs."""

from __future__ import annotations

import pathlib
import re
from typing import Any

import pytest

import fre

ROOT = pathlib.Path(__file__).parents[3]
FENCE = re.compile(r"^ *```python([^\n]*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
PAGES = sorted(
    path
    for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), ROOT / "host/python/README.md"]
    if FENCE.search(path.read_text(encoding="utf-8"))
)


def test_pages_are_found() -> None:
    assert {path.name for path in PAGES} >= {"README.md", "python.md", "optimise.md", "many-machines.md"}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_code_of_a_page_runs(path: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = path.read_text(encoding="utf-8")
    names: dict[str, Any] = {"__name__": "page"}
    for block in FENCE.finditer(text):
        line = text.count("\n", 0, block.start()) + 1
        # Lines as in the page, so that a traceback names the right one.
        code = compile("\n" * line + block[2], str(path), "exec")
        if "not-run=" not in block[1]:
            exec(code, names)


def test_the_first_result_is_what_readers_get() -> None:
    case = fre.Case("preset:ladder-80", fre.Circle(radius_mm=40.0, centre_mm=(41.0, 45.0)), fre.Rotation([2.0, 4.0]))
    assert fre.solve(case).force_magnitude_n == pytest.approx([1.1827, 2.3818], abs=2e-3)
