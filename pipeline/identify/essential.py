"""Essential parameters: those that the record can tell from zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipeline.errors import IdentificationError
from pipeline.identify.regression import subset
from pipeline.identify.wls import wls
from pipeline.records import Estimate, Regression

THRESHOLD_PERCENT = 20.0


class Essential(NamedTuple):
    """kept names; dropped (name, its relative sigma in % when it went), in that order; the estimate of the kept."""

    kept: tuple[str, ...]
    dropped: tuple[tuple[str, float], ...]
    estimate: Estimate


def essential(
    regression: Regression, units: Sequence[str], name: str = "essential", threshold: float = THRESHOLD_PERCENT
) -> Essential:
    """Drop the parameter of the largest %sigma (Eq. 10) while it exceeds `threshold` [%], estimating anew each time.

    The dropped are set to zero, as the paper cancels LMY2 and Fv1 (section 5.1). units (p,) of the parameters.
    Raises IdentificationError where nothing would be left.
    """
    unit = dict(zip(regression.names, units, strict=True))
    kept, dropped = regression.names, []
    while True:
        estimate = wls(subset(regression, kept), name, [unit[k] for k in kept])
        percent = estimate.relative_sigma_percent
        worst = int(np.argmax(percent))
        if percent[worst] <= threshold:
            return Essential(kept, tuple(dropped), estimate)
        dropped.append((kept[worst], float(percent[worst])))
        kept = kept[:worst] + kept[worst + 1 :]
        if not kept:
            raise IdentificationError(
                f"essential parameters: every relative sigma exceeds {threshold:g} %; use a richer trajectory"
            )
