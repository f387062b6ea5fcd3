"""Public names of `flexmb.meshes`: plane meshes, read from files, or made for common outlines."""

from flexmb.planes.files import read as read
from flexmb.planes.mesh import PlaneMesh as PlaneMesh
from flexmb.planes.outlines import crank_web as crank_web
from flexmb.planes.outlines import link_with_eyes as link_with_eyes
from flexmb.planes.outlines import rectangle as rectangle
from flexmb.planes.outlines import ring as ring
from flexmb.planes.plates import plate_with_holes as plate_with_holes
