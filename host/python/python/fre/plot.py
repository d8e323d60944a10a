"""Pictures with matplotlib (``pip install fre[plot]``): what belongs into a figure of one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import objects
from .motion import Rotation
from .solution import Place, Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def finger(solution: Solution, at: int = -1, ax: Axes | None = None, **style: Any) -> Axes:
    """The deformed finger on its object at a place, finger frame, mm; arrows are the contact forces on the object. Of the objects
    only round ones are drawn."""
    ax = _axes(ax)
    place = solution[at]
    colour = style.pop("color", "tab:blue")
    for points in (place.front_mm, place.back_mm):
        ax.plot(points[:, 0], points[:, 1], color=colour, **style)
    for bar in place.lamellae_mm:
        ax.plot(bar[:, 0], bar[:, 1], color=colour, linewidth=1)
    outline = _outline(solution, place)
    if outline is not None:
        ax.plot(outline[:, 0], outline[:, 1], color="0.5")
    if place.contacts:
        where = np.array([contact.position_mm for contact in place.contacts])
        # A contact's normal points out of the object: the finger pushes against it.
        forces = np.array([-contact.force_n * np.asarray(contact.normal) for contact in place.contacts])
        ax.quiver(where[:, 0], where[:, 1], forces[:, 0], forces[:, 1], color="tab:red", width=0.004)
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    return ax


def force(solution: Solution, ax: Axes | None = None, **style: Any) -> Axes:
    """The force's magnitude over the motion; a gap where the status is not trustworthy."""
    ax = _axes(ax)
    ax.plot(solution.places, solution.force_magnitude_n, **{"marker": "o", "markersize": 3, **style})
    rotating = isinstance(solution.case.motion, Rotation)
    ax.set_xlabel("motor angle (°)" if rotating else "distance (mm)")
    ax.set_ylabel("contact force (N)")
    return ax


def pressure(solution: Solution, at: int = -1, ax: Axes | None = None, **style: Any) -> Axes:
    """Contact pressure along the front beam at a place."""
    ax = _axes(ax)
    samples = solution[at].contact_pressure
    arcs = np.array([sample.arc_mm for sample in samples])
    pressures = np.array([sample.pressure_n_per_mm2 for sample in samples])
    # A line from sample to sample would show pressure where nothing touches.
    style = {"color": "tab:red", **style}
    ax.vlines(arcs, 0.0, pressures, **style)
    ax.plot(arcs, pressures, ".", **style)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("arc length of the front beam (mm)")
    ax.set_ylabel("contact pressure (N/mm²)")
    return ax


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots()[1]


def _outline(solution: Solution, place: Place) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """A round object's outline in the finger frame; None for the other shapes."""
    case = solution.case
    shape = case.object
    if not isinstance(shape, (objects.Circle, objects.Bore)):
        return None
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    points = np.asarray(shape.centre_mm) + shape.radius_mm * np.stack([np.cos(around), np.sin(around)], axis=1)
    motion = case.motion
    if isinstance(motion, Rotation):
        # p_finger = M + R(+α)(p_world − M).
        axis, angle = np.asarray(case.finger["motor.axis_mm"]), np.radians(place.motor_angle_deg)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.asarray(axis + (points - axis) @ turn.T)
    direction = np.asarray(motion.direction) / np.hypot(*motion.direction)
    return np.asarray(points - place.distance_mm * direction)
