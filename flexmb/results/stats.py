"""Statistics of a run: steps, iterations, time."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stats:
    """Statistics of a run.

    Parameters
    ----------
    steps : accepted steps.
    rejected : steps tried again with a smaller size.
    newton_iterations : iterations of all steps, the rejected ones included.
    evaluations : evaluations of the equations of motion.
    factorisations : factorisations of the iteration matrix.
    smallest_step, largest_step : among the accepted steps [s].
    wall_time : time that passed on the clock, without that of compilations [s].
    """

    steps: int = 0
    rejected: int = 0
    newton_iterations: int = 0
    evaluations: int = 0
    factorisations: int = 0
    smallest_step: float = 0.0
    largest_step: float = 0.0
    wall_time: float = 0.0

    def __str__(self) -> str:
        """One line."""
        return (
            f"{self.steps} steps of {self.smallest_step:.3g} to {self.largest_step:.3g} s ({self.rejected} rejected), "
            f"{self.newton_iterations} Newton iterations, {self.evaluations} evaluations, "
            f"{self.factorisations} factorisations, {self.wall_time:.3g} s on the clock"
        )
