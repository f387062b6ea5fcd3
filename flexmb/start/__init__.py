"""Start values: closed loops, and positions, velocities, accelerations and multipliers that agree."""
