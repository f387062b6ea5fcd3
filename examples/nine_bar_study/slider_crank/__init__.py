"""Study of the slider-crank with a worn piston pin of Flores, Ambrosio, Claro and Lankarani (2008)."""
