"""Noise by seed: white on every measured position and on every plant input, drawn before the run; and encoders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.errors import ConfigError

Loop = Literal["disturbed", "clean"]


@dataclass(frozen=True)
class Noise:
    """Noise of N samples: position (N, n) rad or m, input (N, n) in the plant input's unit, and where it acts.

    "disturbed": the controller sees the measured position and the input noise drives the plant, while the record holds
    the input that was commanded. "clean": the loop runs without noise, which stands in the record alone.
    quantum (n,): the encoders' steps in rad or m, to which the noisy position is rounded; None or 0: it is not.
    """

    position: np.ndarray
    input: np.ndarray
    loop: Loop = "disturbed"
    quantum: np.ndarray | None = None

    def measured(self, q: np.ndarray, k: int) -> np.ndarray:
        """What the encoders show of the true positions q (n,) at sample k: round((q + noise)/quantum)·quantum (n,)."""
        return quantised(q + self.position[k], self.quantum)


def draw_noise(
    rng: np.random.Generator,
    samples: int,
    sigma_q: Sequence[float],
    sigma_u: Sequence[float],
    loop: Loop = "disturbed",
    quantum_q: Sequence[float] = (),
) -> Noise:
    """White Gaussian noise with standard deviations sigma_q (n,) rad or m and sigma_u (n,) in the input's unit.

    quantum_q (n,) rad or m: the encoders' steps; none given: none. Position and input have streams of their own, drawn
    sample by sample: a longer run begins with the same noise, and both loops of one seed get the same. Raises
    ConfigError for a loop, deviations or steps that make no sense.
    """
    if loop not in ("disturbed", "clean"):
        raise ConfigError(f"noise loop `{loop}` is unknown; choose disturbed or clean")
    sigma_q, sigma_u = np.asarray(sigma_q, float), np.asarray(sigma_u, float)
    if sigma_q.shape != sigma_u.shape or sigma_q.ndim != 1 or np.any(sigma_q < 0) or np.any(sigma_u < 0):
        raise ConfigError(
            f"noise: sigma_q {sigma_q.tolist()} and sigma_u {sigma_u.tolist()}; "
            "give one deviation of at least 0 per joint"
        )
    quantum = np.asarray(quantum_q, float)
    if quantum.size and (quantum.shape != sigma_q.shape or np.any(quantum < 0)):
        raise ConfigError(f"noise: quantum_q {quantum.tolist()}; give one step of at least 0 per joint, or none")
    position, input = (stream.standard_normal((samples, len(sigma_q))) for stream in rng.spawn(2))
    return Noise(position * sigma_q, input * sigma_u, loop, quantum if np.any(quantum) else None)


def quantised(q: np.ndarray, quantum: np.ndarray | None) -> np.ndarray:
    """Positions (..., n) rounded to multiples of the steps (n,); where a step is 0, and without steps, as they are."""
    if quantum is None:
        return q
    step = np.where(quantum > 0.0, quantum, 1.0)
    return np.where(quantum > 0.0, np.round(q / step) * step, q)


def position_variance(sigma_q: Sequence[float], quantum_q: Sequence[float] = ()) -> np.ndarray:
    """Variance (n,) of a measured position: sigma_q² + quantum_q²/12, the latter of an error uniform over a step."""
    quantum = np.asarray(quantum_q, float) if len(quantum_q) else 0.0
    return np.square(np.asarray(sigma_q, float)) + np.square(quantum) / 12.0


def no_noise(samples: int, joints: int) -> Noise:
    """The noise of perfect sensors."""
    return Noise(np.zeros((samples, joints)), np.zeros((samples, joints)), "clean")
