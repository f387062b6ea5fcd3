"""Pressures on the edges of a mesh as nodal forces of the undeformed body."""

import numpy as np

from flexmb.elastic.planes.loads import FollowedEdges, edge_products, loaded_edges


def edge_pressure(mesh, name, pressure, thickness):
    """Nodal forces (2n,) [N] of a pressure [Pa] on the edges of a set, by thickness [m]; > 0 pushes into the body."""
    edges = loaded_edges(mesh, name, thickness)
    products = edge_products(mesh, edges, pressure)
    return FollowedEdges(edges.nodes, products, np.zeros_like(products)).forces(mesh).ravel()
