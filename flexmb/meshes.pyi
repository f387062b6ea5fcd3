"""Public names of `flexmb.meshes`: plane meshes, read from files, or made for common outlines."""

from flexmb.elastic.meshes.files import read as read
from flexmb.elastic.meshes.mesh import PlaneMesh as PlaneMesh
from flexmb.elastic.meshes.outlines import crank_web as crank_web
from flexmb.elastic.meshes.outlines import link_with_eyes as link_with_eyes
from flexmb.elastic.meshes.outlines import plate_with_holes as plate_with_holes
from flexmb.elastic.meshes.outlines import rectangle as rectangle
from flexmb.elastic.meshes.outlines import ring as ring
