"""The errors a user can meet. Each is one line: the thing, the value, the remedy; each kind has its exit code."""


class FmuidError(Exception):
    """Base of every error that `fmuid` reports in one line, without a traceback."""

    exit_code = 1


class ConfigError(FmuidError, ValueError):
    """A wrong call, experiment file or binding (exit code 2)."""

    exit_code = 2


class DataError(FmuidError, ValueError):
    """A data file that cannot be used: column, unit, shape, NaN, time stamps (exit code 2)."""

    exit_code = 2


class ExportError(FmuidError, RuntimeError):
    """A Modelica model that cannot be exported, or a missing compiler (exit code 3)."""

    exit_code = 3


class FmuError(FmuidError, RuntimeError):
    """An FMU that cannot be loaded, bound or stepped, or a simulation that failed (exit code 3)."""

    exit_code = 3


class IdentificationError(FmuidError, ArithmeticError):
    """An identification that has no trustworthy answer (exit code 4)."""

    exit_code = 4
