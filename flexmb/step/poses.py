"""Poses of accepted steps, which a run keeps for its watch (`flexmb.state.poses`)."""

from flexmb.kernels import compiled, copy
from flexmb.state.record import INSTANT, LEAST


@compiled
def watch_step(strain, flow, record):
    """Keep the pose of the last step in its turn, and lows of signals; `strain`: place of the strain energy."""
    t, signals = flow.clock.t, record.signals
    for k in range(record.low_places.shape[0]):
        value = signals[record.low_places[k]]
        if value < record.lows[k, LEAST]:
            record.lows[k, LEAST], record.lows[k, INSTANT] = value, t
    poses = record.poses
    last = poses.times.shape[0] - 1
    number = poses.number
    if signals[strain] > number.strain:
        number.strain = signals[strain]
        _keep(last, t, flow, record)
    number.wait -= 1
    if number.wait > 0:
        return
    if number.count == last:
        _thin(poses)
    _keep(number.count, t, flow, record)
    number.count += 1
    number.wait = number.stride


@compiled
def _keep(row, t, flow, record):
    """Keep the present state in a row."""
    poses = record.poses
    poses.times[row], poses.sizes[row] = t, record.report.size
    copy(record.signals, poses.values[row])
    copy(flow.z, poses.z[row])


@compiled
def _thin(poses):
    """Every second pose, at twice the distance."""
    poses.number.count //= 2
    poses.number.stride *= 2
    for k in range(1, poses.number.count):
        poses.times[k], poses.sizes[k] = poses.times[2 * k], poses.sizes[2 * k]
        copy(poses.values[2 * k], poses.values[k])
        copy(poses.z[2 * k], poses.z[k])
