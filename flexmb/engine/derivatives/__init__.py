"""Exact derivatives of laws that are written as a force alone.

Of the shipped laws `SmoothCoulomb` is written so, and the load-scaled LuGre law of the paper.  All other shipped laws
return derivatives by hand: the chain rule repeats products and branches that a formula by hand shares.  The
differentiated kernel gives the same force to the last bit and derivatives that differ by round-off.  Time of its call
over the time of the kernel by hand: SmoothCoulomb 0.96, BrownMcPhee 1.04, LuGre 1.09, Threlfall 1.10, Stribeck 1.12,
ModifiedCoulomb 1.19 (1.01 of a step of the worn slider-crank), BengisuAkay 1.29.  Derivatives by hand stay in laws
whose ratio exceeds 1.03; so the bits of runs with these laws stay, too.
"""
