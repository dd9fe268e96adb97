"""Where things stand: the rooms of a checkout, or the copies of an installed package and the user's cache.

The FMUs that are built go to `fmus/` of a checkout, else to the user's cache, a folder per version; the environment
variable FMUID_CACHE names another place for either.
"""

import os
from contextlib import suppress
from pathlib import Path

from pipeline import __version__

PACKAGE = Path(__file__).resolve().parent
ROOT = PACKAGE.parent
IN_CHECKOUT = (ROOT / "pyproject.toml").is_file() and (ROOT / "modelica" / "RobotIdentification").is_dir()
SHARE = ROOT if IN_CHECKOUT else PACKAGE / "share"
MODELICA = SHARE / "modelica" / "RobotIdentification"
BINDINGS = SHARE / "fmus"
EXPERIMENTS = PACKAGE / "experiments"
REPORTS = ROOT / "reports" if IN_CHECKOUT else Path.cwd() / "reports"


def _cache() -> Path:
    """The folder of the FMUs that are built."""
    chosen = os.environ.get("FMUID_CACHE")
    if chosen:
        return Path(chosen).expanduser().absolute() / __version__
    if IN_CHECKOUT:
        return BINDINGS
    from platformdirs import user_cache_path

    return user_cache_path("fmuid", appauthor=False) / __version__


FMUS = _cache()


def kernel_cache(fingerprint: str) -> Path | None:
    """The folder of the compiled kernels, made; None where no place can be written."""
    from platformdirs import user_cache_path

    inside = [ROOT / "build"] if IN_CHECKOUT and not os.environ.get("FMUID_CACHE") else [FMUS]
    for place in (*inside, user_cache_path("fmuid", appauthor=False) / __version__):
        folder = place / "kernels" / fingerprint
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
    return None


def built_fmu(name: str, fmi: str = "2") -> Path:
    """The file of an FMU of ours, as FMI version "2" (`scara.fmu`) or "3" (`scara_fmi3.fmu`), built or not."""
    return FMUS / f"{name}{'_fmi3' if fmi == '3' else ''}.fmu"
