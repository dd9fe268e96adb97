"""The search for an exciting trajectory: descents from random starts, the best of them polished, by counts alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from pipeline.simulate.excitation import Objective

LIGHT, FULL, STRICT = 10.0, 300.0, 1000.0
"""Weights of limits and caps: the light one lets a motion find its shape, the strict one holds them to thousandths."""


class Search:
    """The state of a search, which survives an interruption: `x` (m,), the best so far, and `value`, its objective.

    narrate gets a line per start; tell is called after every iteration with done, total and −value: log det, less what
    limits and caps cost.
    """

    def __init__(self, starts: int, iterations: int, narrate=lambda text: None, tell=lambda done, total, best: None):
        self.starts, self.iterations, self.narrate, self.tell = starts, iterations, narrate, tell
        self.objective: Objective | None = None
        self.x, self.value = None, np.inf
        self.done, self.total = 0, (2 * starts + 2) * iterations

    def run(self, objective: Objective, rng: np.random.Generator, adapt: Callable[[np.ndarray], Objective]) -> None:
        """Descend from every start, and keep the best. The same generator gives the same bits.

        adapt: the objective with the margins that a motion x (m,) needs, once its shape is found.
        """
        for i, stream in enumerate(rng.spawn(self.starts)):
            self.done = 2 * i * self.iterations
            x = self._descend(objective, objective.start(stream), LIGHT, self.iterations)
            self.done = (2 * i + 1) * self.iterations
            self._descend(adapt(x), x, FULL, self.iterations)
            self.narrate(f"  start {i + 1} of {self.starts}: best so far {-self.value:.2f}")
        self.done = 2 * self.starts * self.iterations

    def polish(self, objective: Objective, stages: int = 1) -> None:
        """Descend from the best so far with an objective of tighter margins."""
        self.value = np.inf
        self._descend(objective, self.x, STRICT, stages * self.iterations)

    def _descend(self, objective: Objective, x: np.ndarray, rho: float, iterations: int) -> np.ndarray:
        def keep(intermediate_result) -> None:
            x, value = intermediate_result.x.copy(), float(intermediate_result.fun)
            if rho > LIGHT and value < self.value:
                self.objective, self.x, self.value = objective, x, value
            elif self.value == np.inf:
                self.objective, self.x = objective, x
            self.done = min(self.done + 1, self.total)
            self.tell(self.done, self.total, -self.value)

        options = {"maxiter": iterations, "maxcor": 20}
        return minimize(objective, x, (rho,), method="L-BFGS-B", jac=True, callback=keep, options=options).x
