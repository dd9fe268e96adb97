"""The steps of finite differences through a plant."""

from __future__ import annotations

import numpy as np

from pipeline.plant.binding import Binding

# Relative steps where round-off and truncation balance (measured: errors 5e-7 and 3e-9). A purely relative step would
# vanish with the value, so a state counts as at least 1, a parameter as at least its scale in the binding.
EPSILON = {"forward": 1e-7, "central": 1e-5}
STATE_FLOOR = 1.0


def floor(binding: Binding, ns: int) -> np.ndarray:
    """The smallest size that each of [s, chi, u] (ns + p + n,) counts as."""
    return np.concatenate([np.full(ns, STATE_FLOOR), binding.scale, binding.u_range])
