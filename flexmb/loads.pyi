"""Public names of `flexmb.loads`: forces at points, on edges and in bodies, torques, springs."""

from flexmb.parts.loads.force import Force as Force
from flexmb.parts.loads.force import SpringDamper as SpringDamper
from flexmb.parts.loads.force import Torque as Torque
from flexmb.parts.loads.force import TorsionSpring as TorsionSpring
from flexmb.parts.loads.mesh_loads import BodyForce as BodyForce
from flexmb.parts.loads.mesh_loads import EdgeLoad as EdgeLoad
from flexmb.parts.loads.mesh_loads import EdgePressure as EdgePressure
