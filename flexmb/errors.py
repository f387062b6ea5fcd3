"""Exceptions, one class for each kind of error, all derived from `FlexmbError`."""

__all__ = [
    "ArgumentError", "AssemblyError", "FileFormatError", "FlexmbError", "InputError", "KernelError",
    "MissingPackageError", "ModelError", "RestitutionWarning", "SolveError", "WorkerError",
]  # fmt: skip

# Exceptions of a user's function, which may raise any; `KeyboardInterrupt` and `SystemExit` are not among them.
USER_ERRORS = (Exception,)


class FlexmbError(Exception):
    """Base of every error that flexmb raises on purpose."""


class InputError(FlexmbError, ValueError):
    """A value that a part, a law or a function cannot work with."""


class UnknownNameError(KeyError):
    """Base of errors about unknown names, as of any mapping."""

    def __str__(self) -> str:
        """The message as it is; `KeyError` alone would show it in quotes."""
        return str(self.args[0])


class ArgumentError(InputError, TypeError):
    """Arguments that are unknown, missing, or given without their names; also a `TypeError`, as Python's own."""


class ModelError(FlexmbError):
    """Parts that do not fit together: duplicate names, dangling references, redundant joints."""


class KernelError(FlexmbError):
    """A kernel that does not keep its contract: wrong unpacking, NaN, wrong number of outputs."""


class AssemblyError(FlexmbError):
    """Loops that cannot be closed, or a pose in which the joints are not independent."""


class SolveError(FlexmbError):
    """A solver that did not reach its tolerance: statics, eigenvalues, start values."""


class FileFormatError(FlexmbError):
    """A file that is truncated, from another version, or not ours."""


class MissingPackageError(FlexmbError, ImportError):
    """An optional package that is not installed; the message names the command that installs it."""


class WorkerError(FlexmbError, RuntimeError):
    """A worker process that died or cannot be reached; the message names the remedy."""


class RestitutionWarning(UserWarning):
    """A contact law with another coefficient of restitution than its parameter."""
