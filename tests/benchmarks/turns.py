"""Times of runs taken in turn, A B C A B C …, in one process: what disturbs one of them disturbs its neighbours too."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import thread_time

import numpy as np


@dataclass(frozen=True)
class Spread:
    """The median of a quantity over the rounds, and its extremes."""

    median: float
    low: float
    high: float


def in_turn(
    jobs: Mapping[str, Callable[[], object]], rounds: int, clock: Callable[[], float] = thread_time
) -> dict[str, np.ndarray]:
    """What each job takes (rounds,) by `clock`, in its seconds, the jobs run in turn after a warm-up of each."""
    for job in jobs.values():
        job()
    times = {name: np.empty(rounds) for name in jobs}
    gc.collect()
    gc.disable()
    try:
        for k in range(rounds):
            for name, job in jobs.items():
                start = clock()
                job()
                times[name][k] = clock() - start
    finally:
        gc.enable()
    return times


def spread(values: np.ndarray) -> Spread:
    """Median, minimum and maximum of values (rounds,)."""
    return Spread(float(np.median(values)), float(np.min(values)), float(np.max(values)))


def ratio(times: Mapping[str, np.ndarray], of: str, to: str) -> Spread:
    """One job's time over another's, round by round."""
    return spread(times[of] / times[to])
