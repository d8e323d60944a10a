"""Fin-Ray fingers: contact force and shape from the motor angle.

>>> import fre
>>> case = fre.Case(
...     fre.Finger.preset("ladder-80"),
...     fre.Circle(radius_mm=40.0, centre_mm=(41.0, 45.0)),
...     fre.Rotation([2.0, 4.0, 6.0]),
... )
>>> solution = fre.solve(case)
>>> [place.status.name for place in solution]
['converged', 'converged', 'converged']
>>> solution.force_magnitude_n.round(2).tolist()
[1.18, 2.38, 3.8]

Lengths are in mm, forces in N, angles in degrees; every name carries its unit. Positive motor angles close the finger. Forces are
those of the finger on the object.
"""

from ._core import VERSION as __version__
from ._core import CaseError
from .calibration import Calibration, Noise, calibrate
from .case import Case
from .comparison import Comparison, compare
from .estimator import Estimate, Estimator
from .finger import PRESETS, Finger
from .live import Bus, Event, FreeObject, Grasp, Gripper, Margin, Report
from .motion import Motion, Rotation, Translation
from .objects import Bore, Circle, Ellipse, HalfPlane, Object, Polygon
from .options import Options
from .recording import Recording, read_recording
from .record import Record
from .solution import Follower, Place, Solution, solve, solve_many
from .status import Status
from .sweeping import Sweep, merge, sweep

__all__ = [
    "PRESETS",
    "Bore",
    "Bus",
    "Calibration",
    "Case",
    "CaseError",
    "Circle",
    "Comparison",
    "Ellipse",
    "Estimate",
    "Estimator",
    "Event",
    "Finger",
    "Follower",
    "FreeObject",
    "Grasp",
    "Gripper",
    "HalfPlane",
    "Margin",
    "Motion",
    "Noise",
    "Object",
    "Options",
    "Place",
    "Polygon",
    "Record",
    "Recording",
    "Report",
    "Rotation",
    "Solution",
    "Status",
    "Sweep",
    "Translation",
    "__version__",
    "calibrate",
    "compare",
    "merge",
    "read_recording",
    "solve",
    "solve_many",
    "sweep",
]
