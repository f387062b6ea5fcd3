"""Public names of `flexmb.loads`: forces at points, on edges and in bodies, torques, springs."""

from flexmb.loads.body_force import BodyForce as BodyForce
from flexmb.loads.edge_load import EdgeLoad as EdgeLoad
from flexmb.loads.edge_load import EdgePressure as EdgePressure
from flexmb.loads.force import Force as Force
from flexmb.loads.spring_damper import SpringDamper as SpringDamper
from flexmb.loads.torque import Torque as Torque
from flexmb.loads.torsion_spring import TorsionSpring as TorsionSpring
