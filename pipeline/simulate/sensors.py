"""Noise by seed: white on every measured position and on every plant input, drawn before the run."""

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

    "disturbed": the controller sees the noisy position and the input noise drives the plant, while the record holds
    the input that was commanded. "clean": the loop runs without noise, which stands in the record alone.
    """

    position: np.ndarray
    input: np.ndarray
    loop: Loop = "disturbed"


def draw_noise(
    rng: np.random.Generator,
    samples: int,
    sigma_q: Sequence[float],
    sigma_u: Sequence[float],
    loop: Loop = "disturbed",
) -> Noise:
    """White Gaussian noise with standard deviations sigma_q (n,) rad or m and sigma_u (n,) in the input's unit.

    Position and input have streams of their own, drawn sample by sample: a longer run begins with the same noise, and
    both loops of one seed get the same. Raises ConfigError for a loop or deviations that make no sense.
    """
    if loop not in ("disturbed", "clean"):
        raise ConfigError(f"noise loop `{loop}` is unknown; choose disturbed or clean")
    sigma_q, sigma_u = np.asarray(sigma_q, float), np.asarray(sigma_u, float)
    if sigma_q.shape != sigma_u.shape or sigma_q.ndim != 1 or np.any(sigma_q < 0) or np.any(sigma_u < 0):
        raise ConfigError(
            f"noise: sigma_q {sigma_q.tolist()} and sigma_u {sigma_u.tolist()}; "
            "give one deviation of at least 0 per joint"
        )
    position, input = (stream.standard_normal((samples, len(sigma_q))) for stream in rng.spawn(2))
    return Noise(position * sigma_q, input * sigma_u, loop)


def no_noise(samples: int, joints: int) -> Noise:
    """The noise of perfect sensors."""
    return Noise(np.zeros((samples, joints)), np.zeros((samples, joints)), "clean")
