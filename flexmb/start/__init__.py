"""Start values: closed loops; consistent positions, velocities, accelerations and multipliers."""
