"""Time integration methods: the Newmark family, Runge-Kutta for rigid mechanisms, rigid and elastic steps in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace

from flexmb import checks
from flexmb.errors import InputError


@dataclass(frozen=True)
class Newmark:
    """Newmark, HHT, WBZ and generalised-alpha as one implicit method.

        q1 = q0 + h v0 + h^2 ((1/2 - beta) x0 + beta x1),   v1 = v0 + h ((1 - gamma) x0 + gamma x1)
        (1 - alpha_m) x1 + alpha_m x0 = (1 - alpha_f) a1 + alpha_f a0

    where the true accelerations a and the multipliers satisfy the equations of motion at the ends of the steps, so
    both are of second order.  When the step changes, x is carried over as a + ratio (x - a), which keeps the order of
    the motion; joint forces fall to first order where the step changes all the time and nothing dissipates (radius 1).

    Parameters
    ----------
    alpha_m, alpha_f : weights of the averages of accelerations.
    beta, gamma : Newmark's numbers.
    constraints : "gear-gupta-leimkuhler" (positions and velocities hold together, the default), "position" (index 3),
        "velocity" (index 2, positions drift).  The measured difference is in docs/design.md.

    Raises
    ------
    InputError : numbers that are not finite, an unknown form of the constraints.

    Notes
    -----
    Sources: N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94; J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993)
    371-375; M. Arnold, O. Bruls, Multibody Syst. Dyn. 18 (2007) 185-202 (the form with true accelerations).
    """

    alpha_m: float = 0.0
    alpha_f: float = 0.0
    beta: float = 0.25
    gamma: float = 0.5
    constraints: str = "gear-gupta-leimkuhler"

    def __post_init__(self) -> None:
        for name in ("alpha_m", "alpha_f", "beta", "gamma"):
            checks.number("Newmark", name, getattr(self, name))
        checks.positive("Newmark", "beta", self.beta)
        checks.one_of("Newmark", "constraints", self.constraints, ["gear-gupta-leimkuhler", "position", "velocity"])

    @property
    def starting(self) -> Newmark:
        """The method of a first step.

        x stands for the acceleration at a time Delta h later, Delta = alpha_m - alpha_f.  With x0 = a0 the multipliers
        would begin with an error of first order.  x0 = a0 + Delta (a1 - a0) turns the method into a plain Newmark step
        with gamma = 1/2, beta = (1 + Delta^2)/4, whatever its own numbers; after it x = a1 + Delta (a1 - a0).
        """
        delta = self.alpha_m - self.alpha_f
        return replace(self, alpha_m=0.0, alpha_f=0.0, beta=0.25 * (1.0 + delta * delta), gamma=0.5)

    @classmethod
    def trapezoidal(cls, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """The trapezoidal rule: beta = 1/4, gamma = 1/2, no dissipation.

        Parameters
        ----------
        constraints : see the class.
        """
        return cls(constraints=constraints)

    @classmethod
    def hht(cls, alpha: float = 0.1, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """Hilber, Hughes, Taylor with 0 <= alpha <= 1/3.

        Parameters
        ----------
        alpha : weight of the old forces.
        constraints : see the class.
        """
        checks.between("Newmark.hht", "alpha", alpha, 0.0, 1.0 / 3.0)
        return cls(0.0, alpha, (1.0 + alpha) ** 2 / 4.0, 0.5 + alpha, constraints)

    @classmethod
    def wbz(cls, alpha: float = 0.1, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """Wood, Bossak, Zienkiewicz with 0 <= alpha <= 1/3.

        Parameters
        ----------
        alpha : weight of the old accelerations, taken negative.
        constraints : see the class.
        """
        checks.between("Newmark.wbz", "alpha", alpha, 0.0, 1.0 / 3.0)
        return cls(-alpha, 0.0, (1.0 + alpha) ** 2 / 4.0, 0.5 + alpha, constraints)

    @classmethod
    def generalised_alpha(cls, radius: float = 0.8, constraints: str = "gear-gupta-leimkuhler") -> Newmark:
        """Chung and Hulbert: least dissipation at low frequencies for a given spectral radius at infinity.

        Parameters
        ----------
        radius : spectral radius at infinite frequency, 0 (annihilation) to 1 (no dissipation).
        constraints : see the class.
        """
        checks.between("Newmark.generalised_alpha", "radius", radius, 0.0, 1.0)
        alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        return cls(alpha_m, alpha_f, (1.0 - alpha_m + alpha_f) ** 2 / 4.0, 0.5 - alpha_m + alpha_f, constraints)


@dataclass(frozen=True)
class RungeKutta4:
    """Classical explicit Runge-Kutta of order 4; positions and velocities are projected after every step.

    For rigid mechanisms.  Beams are stiff: their fastest wave sets the step, so use `Newmark` for them.
    """


@dataclass(frozen=True)
class Staggered:
    """A rigid and an elastic model that take steps in turn, each with what the other found last.

    1. Runge and Kutta's step of the rigid mechanism: every flexible body is replaced by the rigid one of the same mass,
       centre and inertia; contact forces come from its motion.
    2. Newmark's step (beta = 1/4, gamma = 1/2) of linear elasticity about the pose found, U being the displacements of
       the nodes along X and Y and their rotations:

           M U'' + (C + 2 R^T m R') U' + (K + R^T m R'') U = F - M a_r,    G U = 0

       with u = R U in the axes of a body, F of contact, loads and weight, a_r accelerations of the rigid model, and G
       the joints and drives of the pose; C is the damping of the bodies.
    3. The inertia force and moment of the elastic motion, summed body by body, load the rigid model in the next step.

    For mechanisms of `RigidBody`, `RigidLink`, `FlexibleLink`, `FlexibleFrame`, with joints without friction in ideal
    ones, drives, contacts and loads, and springs between rigid ones; with `FixedStep` only.

    Parameters
    ----------
    rotation : terms of the rotating axes: "printed", as above; or "inertial", without 2 R^T m R' and R^T m R'', and
        with damping of the rates seen from the body.  See the notes.
    play : what a joint with play does to U: "independent", nothing; or "shared", both of its ends are displaced alike.
    mean_axes : whether rigid motions that G leaves to U are taken out of it: it then has no momentum in any of them.
    passes : times each step is done, with the inertia of the elastic motion that was found at its end, >= 1.

    Raises
    ------
    InputError : an unknown word, passes that are no whole number > 0.

    Notes
    -----
    Where U is in fixed axes, M U'' is the inertia force; the printed terms are correct for none but u'' in place of
    the accelerations, that is for slow turning.  A beam that turns at w has, in the plane, the frequency at rest f
    with "printed", sqrt(f^2 - w^2) with "inertial"; centrifugal forces, which stiffen it, are in neither.

    Drive torques, forces of joints and contacts, ex and ey are those of the rigid model with the load of step 3.
    Positions, velocities and accelerations of nodes are those of the rigid model plus U, U', U''.  Energies belong to
    this sum, and `energy.residual` is what the coupling made or lost.  Loads see the rigid motion only.

    Contacts see the rigid motion alone.  With "independent" displacements and mean axes, U has no momentum in what the
    joints leave free, so impacts are those of the rigid mechanism: compliance softens none.  With "shared" ones the
    play is that of the whole motion, and the scheme tends to the coupled linear equations as h tends to 0.  But the
    load of step 3 is one step late, and nearly as large as the inertia of the rigid model: in contact that acts as
    negative damping, and runs with one pass blow up at any step that can be afforded (docs/design.md); passes repeated
    until the load stays give the impacts of the coupled equations, to the first order of h.  Without mean axes, rigid
    motions of U are neutral: they keep whatever disturbs them.

    Source: X. Chen, S. Jiang, Y. Deng, Q. Wang, Nonlinear Dynamics (2018), section 4, eqs (26)-(30) and 4.4.  There the
    vectors U^1 and U^2 share the coordinates of the clearance joint, though the text calls its members independent.
    """

    rotation: str = "printed"
    play: str = "independent"
    mean_axes: bool = True
    passes: int = 1

    def __post_init__(self) -> None:
        checks.one_of("Staggered", "rotation", self.rotation, ["printed", "inertial"])
        checks.one_of("Staggered", "play", self.play, ["independent", "shared"])
        if not isinstance(self.mean_axes, bool):
            raise InputError(f"Staggered: mean_axes is {self.mean_axes!r}; it must be True or False.")
        checks.count("Staggered", "passes", self.passes)
