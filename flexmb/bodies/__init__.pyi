"""Public names of `flexmb.bodies`: rigid bodies and links, particles, flexible links and frames, smooth curves."""

from flexmb.bodies.flexible_frame import FlexibleFrame as FlexibleFrame
from flexmb.bodies.flexible_link import FlexibleLink as FlexibleLink
from flexmb.bodies.point_mass import PointMass as PointMass
from flexmb.bodies.rigid_body import RigidBody as RigidBody
from flexmb.bodies.rigid_link import RigidLink as RigidLink
from flexmb.bodies.smooth import smooth_turns as smooth_turns
