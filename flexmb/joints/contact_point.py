"""What gap kernels write about the contact point that both bodies share (see `flexmb.kernels.GAP_SIZE`)."""

from flexmb.kernels import compiled


@compiled
def put_point(out, q, v, gap, nx, ny, X, Y):
    """Gap, its rate, slip, normal and arms for a contact point (X, Y) that is moved with either body in turn."""
    r1x, r1y, r2x, r2y = X - q[0], Y - q[1], X - q[3], Y - q[4]
    ux, uy = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    out[0], out[1], out[2] = gap, -(nx * ux + ny * uy), nx * uy - ny * ux
    out[3], out[4], out[5], out[6], out[7], out[8] = nx, ny, r1x, r1y, r2x, r2y


@compiled
def put_column(out, j, nqx, nqy, Xq, Yq):
    """Derivatives of the normal, and those of both arms from that of the contact point, by coordinate j."""
    out[13 + j], out[19 + j] = nqx, nqy
    out[25 + j], out[31 + j] = Xq - (1.0 if j == 0 else 0.0), Yq - (1.0 if j == 1 else 0.0)
    out[37 + j], out[43 + j] = Xq - (1.0 if j == 3 else 0.0), Yq - (1.0 if j == 4 else 0.0)
