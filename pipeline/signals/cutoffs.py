"""Cut-offs and decimation of a WLS variant: those that are set, and those that follow the closed loop's bandwidth."""

from __future__ import annotations

from msgspec.structs import replace

from pipeline.errors import ConfigError
from pipeline.settings import Filter, WlsSettings

CHEBYSHEV_BAND = 0.8
"""Where the filter "decimate" ends, as a fraction of the decimated Nyquist."""
POSITION, PARALLEL = 5.0, 2.0
"""Cut-offs of the position filter and of the parallel filter, in multiples of f_dyn (Gautier & Poignet 2001, 5.1)."""
MARGIN = 1.15
"""Least ratio of the decimated Nyquist to a parallel cut-off: there 4th-order zero-phase is down to a quarter."""
DIGITS = 3
"""Significant digits of a cut-off that follows the loop: who sets the printed number gets the same filter."""


def follows_loop(settings: WlsSettings) -> bool:
    """Whether a cut-off of the variant is to be taken from the closed loop."""
    return _open(settings.position) or _open(settings.parallel)


def resolve(settings: WlsSettings, rate: float, f_dyn: float | None = None) -> WlsSettings:
    """The variant with every number in its place, for data at `rate` (Hz) from a loop of bandwidth f_dyn (Hz).

    Raises ConfigError where a cut-off is not below Nyquist, or the parallel cut-off above the decimated Nyquist.
    """
    if f_dyn is None and follows_loop(settings):
        raise ConfigError(f"{settings.name}: a filter without a cut-off needs [controller] to take it from; set it")
    if _open(settings.position) and POSITION * f_dyn >= 0.5 * rate:
        raise ConfigError(
            f"{settings.name}: {POSITION:g} f_dyn = {POSITION * f_dyn:.3g} Hz, from the closed loop, is not below "
            f"Nyquist, {0.5 * rate:g} Hz; record faster or set the position filter's cut-off"
        )
    position = _filled(settings.position, POSITION, f_dyn)
    parallel = _filled(settings.parallel, PARALLEL, f_dyn)
    decimation = settings.decimation or _largest(parallel, rate)
    found = replace(settings, position=position, parallel=parallel, decimation=decimation)
    check_cutoffs(found, rate)
    return found


def check_cutoffs(settings: WlsSettings, rate: float) -> None:
    """Refuse cut-offs that are set and cannot be at `rate` (Hz), with the number and the remedy; ConfigError."""
    for which in ("position", "parallel"):
        cutoff = _cutoff(getattr(settings, which))
        if cutoff is not None and cutoff >= 0.5 * rate:
            raise ConfigError(
                f"{settings.name}: the {which} filter's cut-off {cutoff:g} Hz is not below Nyquist, {0.5 * rate:g} Hz; "
                "lower it"
            )
    if settings.parallel.kind == "decimate" and (settings.decimation or 1) == 1:
        raise ConfigError(f"{settings.name}: a parallel filter of kind `decimate` needs a decimation above 1; set it")
    cutoff, decimated = _cutoff(settings.parallel), 0.5 * rate / (settings.decimation or 1)
    if cutoff is not None and cutoff > decimated:
        raise ConfigError(
            f"{settings.name}: decimation {settings.decimation} leaves a Nyquist of {decimated:.3g} Hz, below the "
            f"parallel cut-off {cutoff:g} Hz; decimate less or lower it"
        )


def check_border(name: str, border: tuple[int, int], samples: int) -> None:
    """Refuse a border that leaves nothing of a record of `samples`; ConfigError."""
    first, last = border
    if first + last >= samples:
        raise ConfigError(f"{name}: border {first} + {last} leaves none of {samples} samples; cut fewer")


def cutoff_frequency(rate: float, settings: Filter, decimation: int = 1) -> float:
    """Cut-off [Hz] of the filter, the Nyquist frequency for "none"."""
    if settings.kind == "none":
        return 0.5 * rate
    return CHEBYSHEV_BAND * 0.5 * rate / decimation if settings.kind == "decimate" else settings.cutoff


def described(settings: WlsSettings, resolved: WlsSettings, rate: float) -> dict:
    """Of each number of a resolved variant: its value, in Hz or samples, and where it comes from."""
    found = {}
    for which, factor in (("position", POSITION), ("parallel", PARALLEL)):
        kind = getattr(resolved, which)
        value = None if kind.kind == "none" else cutoff_frequency(rate, kind, resolved.decimation)
        found[which] = {"value": value, "source": _source(getattr(settings, which), factor)}
    source = "largest for the parallel cut-off" if _cutoff(resolved.parallel) is not None else "every sample"
    source = "set" if settings.decimation else source
    return {**found, "decimation": {"value": resolved.decimation, "source": source}}


def _source(settings: Filter, factor: float) -> str:
    if settings.kind == "none":
        return "no filter"
    if settings.kind == "decimate":
        return "0.8 of the decimated Nyquist"
    return f"{factor:g} f_dyn" if _open(settings) else "set"


def _open(settings: Filter) -> bool:
    return settings.kind in ("zero-phase", "forward") and settings.cutoff is None


def _cutoff(settings: Filter) -> float | None:
    return settings.cutoff if settings.kind in ("zero-phase", "forward") else None


def _filled(settings: Filter, factor: float, f_dyn: float | None) -> Filter:
    return replace(settings, cutoff=float(f"{factor * f_dyn:.{DIGITS}g}")) if _open(settings) else settings


def _largest(parallel: Filter, rate: float) -> int:
    """The largest decimation whose Nyquist frequency is MARGIN times the cut-off: rows as independent as can be."""
    cutoff = _cutoff(parallel)
    return 1 if cutoff is None else max(1, int(0.5 * rate / (MARGIN * cutoff)))
