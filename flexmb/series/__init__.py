"""What one sampled signal says about the system behind it."""
