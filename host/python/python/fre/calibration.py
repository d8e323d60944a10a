"""The model's parameters from measurements."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Sequence
from typing import Any, Literal

from . import _core
from .case import Case, CaseLike
from .finger import Finger
from .options import DEFAULT, Options
from .record import Record

PathLike = "str | os.PathLike[str]"


@dataclasses.dataclass(frozen=True)
class Noise:
    """How far measurements may be off."""

    force_sd_n: float = 0.02
    """Standard deviation of a force, N."""
    angle_sd_deg: float | None = None
    """Of an angle, degrees. None: a servo's count over √12."""
    outline_sd_mm: float = 0.3
    """Of a point of an outline, mm."""
    loss: Literal["huber", "tukey", "square"] = "huber"
    """How readings far off count."""
    torque_sd_nmm: float | None = None
    """Standard deviation of a motor torque, N·mm. None: torques are left out."""


class Calibration(Record):
    """A fit; its names are those of ``fre calibrate --format json``: ``parameters``, ``correlation``, ``residuals`` and so on."""

    __slots__ = ("_finger", "_svg", "text")

    def __init__(self, json: dict[str, Any], text: str, finger: str, svg: str) -> None:
        super().__init__(json)
        self.text = text
        """The table of ``fre calibrate``."""
        self._finger = finger
        self._svg = svg

    def __getattr__(self, name: str) -> Any:
        return super().__getattr__(name)

    def parameter(self, name: str) -> Record:
        """A parameter by its word: ``value``, ``standard_deviation``, ``start``, ``unit``, ``determined``."""
        for parameter in self["parameters"]:
            if parameter["parameter"] == name:
                found: Record = parameter
                return found
        raise KeyError(name)

    @property
    def finger(self) -> Finger:
        """The finger with the fitted values."""
        return Finger.parse(self._finger)

    @property
    def finger_toml(self) -> str:
        """Its file, the standard deviations in the comments."""
        return self._finger

    def svg(self) -> str:
        """Forces or torques, and residuals."""
        return self._svg

    def _repr_svg_(self) -> str:
        return self._svg

    def __repr__(self) -> str:
        fitted = ", ".join(f"{p['parameter']} {p['value']:.5g} ± {p['standard_deviation']:.2g} {p['unit']}" for p in self["parameters"])
        return f"<fre.Calibration {fitted}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Calibration, (self.to_dict(), self.text, self._finger, self._svg)


def calibrate(
    measurements: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    cases: CaseLike | Sequence[CaseLike],
    fit: Sequence[str] = ("youngs-modulus", "zero", "object-x", "object-y"),
    noise: Noise = Noise(),
    *,
    both_ways: bool = False,
    options: Options = DEFAULT,
) -> Calibration:
    """Fits modulus, zero angle, object offset, friction, dimensions or the terms of a material with memory to files of measurements, with uncertainties.

    Each file belongs to the case in the same place, or to the only one. ``fit`` names parameters by the words of
    ``fre calibrate --fit``. Rows of an opening motion are left out unless ``both_ways``.
    """
    files = [measurements] if isinstance(measurements, (str, os.PathLike)) else list(measurements)
    each = list(cases) if isinstance(cases, Sequence) and not isinstance(cases, str) else [cases]
    core = [Case.of(case)._case for case in each]
    found = _core.calibrate([os.fspath(file) for file in files], core, list(fit), noise, both_ways, options)
    json_text, text, finger, svg = found
    return Calibration(json.loads(json_text), text, finger, svg)
