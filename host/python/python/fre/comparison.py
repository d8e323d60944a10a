"""A case against measurements or finite elements."""

from __future__ import annotations

import json
import os
import tempfile
from typing import Any, Literal

from . import _core
from .case import Case, CaseLike
from .error import case_error
from .options import DEFAULT, Options
from .record import Record


class Comparison(Record):
    """A comparison; its names are those of ``fre compare --format json``: ``rows`` with a record per place, ``notes``, ``fea``."""

    __slots__ = ("_svg", "text")

    def __init__(self, json: dict[str, Any], text: str, svg: str | None) -> None:
        super().__init__(json)
        self.text = text
        """The table of ``fre compare``."""
        self._svg = svg

    def _repr_svg_(self) -> str | None:
        return self._svg

    def svg(self) -> str | None:
        """Both shapes at the last place (finite elements), or forces and residuals (measurements)."""
        return self._svg

    def __repr__(self) -> str:
        return f"<fre.Comparison of {len(self['rows'])} places with {self['reference']}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Comparison, (self.to_dict(), self.text, self._svg)


def compare(
    case: CaseLike,
    measured: str | os.PathLike[str] | None = None,
    *,
    fea: bool = False,
    order: Literal["closing", "file"] = "closing",
    mesh: int = 1,
    folder: str | os.PathLike[str] | None = None,
    options: Options = DEFAULT,
) -> Comparison:
    """Compares a case with a CSV of measurements, or with finite elements (``fea=True``; needs CalculiX' ``ccx``).

    ``order`` is that of the measured places; ``mesh`` makes every finite element so many by so many; CalculiX' files go into
    ``folder``, or into a temporary one.
    """
    if (measured is None) == (not fea):
        raise case_error("compare needs either a file of measurements or fea=True", "measured")
    core = Case.of(case)._case
    if measured is not None:
        found, text, svg = _core.compare_measured(core, os.fspath(measured), order, options)
    elif folder is not None:
        found, text, svg = _core.compare_elements(core, os.fspath(folder), mesh, options)
    else:
        with tempfile.TemporaryDirectory(prefix="fre-fea-") as temporary:
            found, text, svg = _core.compare_elements(core, temporary, mesh, options)
    return Comparison(json.loads(found), text, svg)
