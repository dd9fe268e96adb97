"""fmuid: identify a robot's parameters from data, through any plant that comes as an FMU."""

__version__ = "0.1.0"
