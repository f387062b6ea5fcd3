"""Contact laws: normal forces, friction, onset, coefficient of restitution, validity."""
