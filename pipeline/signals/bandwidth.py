"""The sampled closed loop of a linear plant and a linear controller: its bandwidth and its margins, by python-control.

plant: u (n) → q (n), continuous; controller: [reference, q] (2n) → u (n), sampled with a period, its output held. The
controller answers to q(t_k) in the same sample, so the loop has no delay but the hold.
"""

from __future__ import annotations

from dataclasses import dataclass

import control
import numpy as np
from scipy.optimize import brentq

from pipeline.errors import ConfigError

DROP = 10.0 ** (-3.0 / 20.0)
LOWEST, POINTS = 1e-5, 400
"""The grid of frequencies: from this fraction of Nyquist up to it, so many points."""
HANKEL_TOLERANCE = 1e-9
"""Singular values of the Hankel matrix below this fraction of the largest are rounding."""
REALISED = 1e-6
STABLE = 1.0 - 1e-9
TINY = 1e-300  # a loop that is open has a logarithm too


@dataclass(frozen=True)
class Margins:
    """Margins of one joint's loop, broken at the plant's input; frequencies in Hz. None: no such crossing.

    gain: factor to the limit of stability, the nearer of both directions; phase: in degrees, at the crossover
    `phase_at` where the loop's gain is 1; modulus: least distance from −1, the inverse of the largest sensitivity.
    """

    gain: float | None
    gain_at: float | None
    phase: float | None
    phase_at: float | None
    modulus: float
    modulus_at: float


@dataclass(frozen=True)
class LoopResponse:
    """A closed loop: −3 dB bandwidth (n,) Hz and margins by joint; gain (F, n) over f (F,) in Hz.

    gain: |reference → position| of each joint, relative to that at rest.
    """

    bandwidth: np.ndarray
    margins: tuple[Margins, ...]
    f: np.ndarray
    gain: np.ndarray


def sampled_plant(A: np.ndarray, B: np.ndarray, period: float) -> control.StateSpace:
    """The plant ds/dt = A s + B u, s = [qd, q], its input held over each period (s): u → q, exact at the samples."""
    n = B.shape[1]
    C = np.hstack([np.zeros((n, n)), np.eye(n)])
    return control.sample_system(control.ss(A, B, C, np.zeros((n, n))), period, "zoh")


def realise(markov: np.ndarray, period: float) -> control.StateSpace:
    """The controller with these Markov parameters (outputs, inputs, samples), by the eigensystem realisation algorithm.

    Half of the samples build it (Juang & Pappa 1985, with as many states as the Hankel matrix has singular values above
    rounding), all of them must come back. Raises ConfigError where they do not: an order too high, or not linear.
    """
    scale = np.max(np.abs(markov), axis=(1, 2), initial=0.0)
    scale = np.where(scale > 0.0, scale, 1.0)[:, None]  # outputs of different units weigh alike
    H = markov / scale[:, :, None]
    found = control.ss([], [], [], H[:, :, 0], True)
    if np.max(np.abs(H[:, :, 1:])) > HANKEL_TOLERANCE:
        rows = (H.shape[2] // 2 - 1) // 2
        _, s = control.eigensys_realization(H, 1, m=rows, n=rows)
        order = int(np.sum(s > HANKEL_TOLERANCE * s[0]))
        found, _ = control.eigensys_realization(H, order, m=rows, n=rows)
    if np.max(np.abs(_markov(found, H.shape[2]) - H)) > REALISED:
        raise ConfigError(f"controller: its pulse responses are not those of a linear system of order {found.nstates}")
    return control.ss(found.A, found.B, scale * found.C, scale * found.D, period)


def _markov(system: control.StateSpace, samples: int) -> np.ndarray:
    """[D, CB, CAB, …] (outputs, inputs, samples)."""
    columns, state = [system.D], system.B
    for _ in range(samples - 1):
        columns.append(system.C @ state)
        state = system.A @ state
    return np.stack(columns, axis=2)


def analyse(plant: control.StateSpace, controller: control.StateSpace) -> LoopResponse:
    """Bandwidth and margins of the closed loop. ConfigError where it is not stable, or has no bandwidth."""
    closed = close(plant, controller)
    radius = float(np.max(np.abs(closed.poles())))
    if radius >= STABLE:
        raise ConfigError(f"closed loop: not stable, its largest pole has magnitude {radius:.4f}")
    nyquist = 0.5 / plant.dt
    f = np.geomspace(LOWEST, 1.0, POINTS) * nyquist
    at_rest = np.abs(np.diag(closed(1.0, squeeze=False)))
    if not (np.isfinite(at_rest).all() and at_rest.min() > 0.0):
        raise ConfigError(f"closed loop: joint {int(np.argmin(at_rest)) + 1} does not follow its reference at rest")
    gain = _gain(closed, f) / at_rest
    bandwidth = np.array([_bandwidth(closed, i, f, gain[:, i], at_rest[i]) for i in range(plant.noutputs)])
    return LoopResponse(bandwidth, tuple(_margins(L, f) for L in _broken(plant, controller, f)), f, gain)


def close(plant: control.StateSpace, controller: control.StateSpace) -> control.StateSpace:
    """The closed loop, reference (n) → position (n)."""
    n = plant.noutputs
    forward = plant * controller
    twice = control.ss(forward.A, forward.B, np.tile(forward.C, (2, 1)), np.tile(forward.D, (2, 1)), plant.dt)
    return twice.lft(control.ss([], [], [], np.eye(n), plant.dt))


def _response(system: control.StateSpace, f: np.ndarray) -> np.ndarray:
    """The frequency response (F, outputs, inputs) at f (F,) in Hz."""
    z = np.exp(2j * np.pi * f * system.dt)[:, None, None]  # in one call: python-control's own takes one solve at a time
    states = np.linalg.solve(
        z * np.eye(system.nstates) - system.A, np.broadcast_to(system.B, (len(f), *system.B.shape))
    )
    return system.C @ states + system.D


def _gain(closed: control.StateSpace, f: np.ndarray) -> np.ndarray:
    """|reference i → position i| (F, n) at f (F,) in Hz."""
    return np.abs(np.einsum("fii->fi", _response(closed, f)))


def _bandwidth(closed: control.StateSpace, joint: int, f: np.ndarray, gain: np.ndarray, at_rest: float) -> float:
    """Frequency (Hz) where a joint's gain (F,), relative to that at rest, first falls through −3 dB."""
    below = np.flatnonzero(gain < DROP)
    if not below.size or below[0] == 0:
        raise ConfigError(f"closed loop: joint {joint + 1} has no −3 dB bandwidth below Nyquist")
    low, high = f[below[0] - 1], f[below[0]]
    return float(brentq(lambda x: _gain(closed, np.array([x]))[0, joint] - DROP * at_rest, low, high))


def _broken(plant: control.StateSpace, controller: control.StateSpace, f: np.ndarray) -> list[np.ndarray]:
    """For each joint its loop's response (F,), broken at the plant's input with the other loops closed."""
    n = plant.noutputs
    L = -_response(controller, f)[:, :, n:] @ _response(plant, f)
    loops = []
    for i in range(n):
        others = [j for j in range(n) if j != i]
        inner = np.eye(n - 1) + L[:, others][:, :, others]
        through = L[:, [i]][:, :, others] @ np.linalg.solve(inner, L[:, others][:, :, [i]])
        loops.append(L[:, i, i] - through[:, 0, 0])
    return loops


def _margins(L: np.ndarray, f: np.ndarray) -> Margins:
    """Margins of a loop's response L (F,), log|L| and the phase interpolated between the points of the grid."""
    gain, phase, x = np.log(np.maximum(np.abs(L), TINY)), np.unwrap(np.angle(L)), np.log(f)
    past = np.remainder(phase, 2.0 * np.pi) - np.pi  # 0 on the negative real axis
    at_phase = _crossings(x, np.where(np.abs(past) < 0.5 * np.pi, past, np.nan))
    at_gain = _crossings(x, gain)
    gains, phases = np.interp(at_phase, x, gain), np.interp(at_gain, x, phase)
    phases = np.degrees(np.remainder(phases, 2.0 * np.pi) - np.pi)
    distance = np.abs(1.0 + L)
    nearest = int(np.argmin(distance))
    return Margins(
        *_least(np.exp(-gains), np.abs(gains), at_phase),
        *_least(phases, np.abs(phases), at_gain),
        float(distance[nearest]),
        float(f[nearest]),
    )


def _crossings(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where the curve y over x (F,) changes sign, between points where it is known."""
    k = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    return x[k] - y[k] * (x[k + 1] - x[k]) / (y[k + 1] - y[k])


def _least(values: np.ndarray, sizes: np.ndarray, at: np.ndarray) -> tuple[float | None, float | None]:
    if not values.size:
        return None, None
    k = int(np.argmin(sizes))
    return float(values[k]), float(np.exp(at[k]))
