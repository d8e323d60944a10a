"""Reads a description with the URDF parser of ROS for Python, and its mesh with trimesh: urdf.py FILE.urdf"""

import pathlib
import sys

import numpy
import trimesh
from urdf_parser_py.urdf import URDF

DENSITY = 1200.0

path = pathlib.Path(sys.argv[1])
robot = URDF.from_xml_file(str(path))
assert robot.get_root() == "gripper", robot.get_root()
assert robot.get_chain("gripper", "finger_1", joints=True, links=False) == ["finger_1_base_mount", "finger_1_joint"]
joints = robot.joint_map
assert {joints[f"finger_{number}_joint"].type for number in range(2)} == {"revolute"}
assert joints["finger_1_joint"].mimic.joint == "finger_0_joint" and joints["finger_0_joint"].mimic is None

for number in range(2):
    link = robot.link_map[f"finger_{number}"]
    visual = link.visual
    mesh = trimesh.load(path.parent / visual.geometry.filename)
    assert mesh.is_watertight and mesh.is_winding_consistent
    # The description's scale and place, which turns nothing.
    assert list(visual.origin.rpy) == [0, 0, 0]
    mesh.apply_scale(visual.geometry.scale)
    mesh.apply_translation(visual.origin.xyz)
    mesh.density = DENSITY
    inertial = link.inertial
    assert abs(inertial.mass - mesh.mass) < 1e-5 * mesh.mass, (inertial.mass, mesh.mass)
    assert numpy.allclose(inertial.origin.xyz, mesh.center_mass, atol=1e-6), (inertial.origin.xyz, mesh.center_mass)
    inertia = numpy.array(inertial.inertia.to_matrix())
    assert numpy.allclose(inertia, mesh.moment_inertia, atol=1e-4 * inertia.max()), (inertia, mesh.moment_inertia)
    # What physics engines ask for.
    moments = numpy.linalg.eigvalsh(inertia)
    assert moments[0] > 0 and moments[0] + moments[1] > moments[2], moments
