"""The transition and its Jacobian by finite differences through the plant, the time held for all of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Relative steps where round-off and truncation balance (measured: errors 5e-7 and 3e-9). A purely relative step would
# vanish with the value, so a state counts as at least 1, a parameter as at least its scale in the binding.
EPSILON = {"forward": 1e-7, "central": 1e-5}
STATE_FLOOR = 1.0


@dataclass(frozen=True)
class Linearised:
    """s⁺ = f(s, chi, u): f (ns,); A (ns, ns) = ∂f/∂s; B (ns, p) = ∂f/∂chi; C (ns, n) = ∂f/∂u."""

    f: np.ndarray
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray


def linearise(plant, s: np.ndarray, chi: np.ndarray, u: np.ndarray, t: float, dt: float, mode: str) -> Linearised:
    """Linearise the plant's transition over dt (s) at s (ns,), chi (p,), u (n,), by `mode` "forward" or "central".

    The plant evaluates 1 + m (forward) or 1 + 2m (central) transitions, m = ns + p + n.
    """
    f = plant.transition(s, u, chi, t, dt)
    ns, p = len(s), len(chi)
    point = np.concatenate([s, chi, u])
    floor = np.concatenate([np.full(ns, STATE_FLOOR), plant.binding.scale, plant.binding.u_range])
    step = EPSILON[mode] * np.maximum(np.abs(point), floor)
    J = np.empty((ns, len(point)))
    for i in range(len(point)):
        moved = point.copy()
        moved[i] += step[i]
        ahead = plant.transition(moved[:ns], moved[ns + p :], moved[ns : ns + p], t, dt)
        if mode == "forward":
            # the step that was taken, not the one that was asked for: the difference is rounding
            J[:, i] = (ahead - f) / (moved[i] - point[i])
            continue
        back = point.copy()
        back[i] -= step[i]
        behind = plant.transition(back[:ns], back[ns + p :], back[ns : ns + p], t, dt)
        J[:, i] = (ahead - behind) / (moved[i] - back[i])
    return Linearised(f, J[:, :ns], J[:, ns : ns + p], J[:, ns + p :])
