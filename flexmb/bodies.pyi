"""Public names of `flexmb.bodies`: rigid bodies and links, particles, flexible links and frames, smooth curves."""

from flexmb.parts.bodies.flexible_links import FlexibleFrame as FlexibleFrame
from flexmb.parts.bodies.flexible_links import FlexibleLink as FlexibleLink
from flexmb.parts.bodies.flexible_links import smooth_turns as smooth_turns
from flexmb.parts.bodies.rigid import PointMass as PointMass
from flexmb.parts.bodies.rigid import RigidBody as RigidBody
from flexmb.parts.bodies.rigid import RigidLink as RigidLink
