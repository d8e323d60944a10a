"""How a case is solved."""

from __future__ import annotations

import dataclasses
from typing import Literal

from . import _core


@dataclasses.dataclass(frozen=True)
class Options:
    """How the model is discretised and solved: the options of the ``fre`` command, by the same words."""

    scheme: Literal["paper", "trapezoid", "simpson"] = "simpson"
    """Scheme of beams and hinges."""
    elements: str = "fine"
    """Elements per beam and per hinge as ``"B/H"``, or ``"paper"``, ``"reduced"``, ``"fine"``."""
    samples: int | None = None
    """Contact samples per element, 1 to 16. None: 4 with ``simpson``, the nodes with the other schemes."""
    softness_mm_per_n: float | None = None
    """Contact softness, mm/N. None: the front beam's own with samples, 0 with nodes."""
    physics: Literal["paper", "extended"] = "extended"
    """What the finger is made of: as the paper has it, or as the case says."""
    hessian: Literal["newton", "gauss-newton"] = "newton"
    """Second derivative of the Newton step."""
    precision: Literal["f64", "f32"] = "f64"
    """Floating-point precision."""

    def __post_init__(self) -> None:
        _core.check_options(self)


DEFAULT = Options()
