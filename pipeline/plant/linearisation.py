"""What two FMUs are near a rest: the plant's A and B from its derivatives, the controller's pulse responses.

A sampled controller keeps its memory in discrete states, through which no standard differentiates; its answers to small
pulses hold all that a linear controller is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.errors import ConfigError, FmuError
from pipeline.plant.binding import Binding
from pipeline.plant.cosimulation import Slave
from pipeline.plant.fmu import Fmu
from pipeline.plant.model_exchange import ModelExchangePlant
from pipeline.settings import ControllerSettings

STATE_STEP = 1e-5  # rad, m and their rates: truncation and round-off of a central difference balance
PROBE, PULSE = 1e-6, -0.1
"""The first pulse (rad or m); the second makes a command of this fraction of u_range, inside every saturation."""
REST, SAMPLES = 2, 64
"""Samples before a pulse, and from it on."""
TOLERANCE = 1e-6


@dataclass(frozen=True)
class LinearPlant:
    """ds/dt = A s + B u about rest at q (n,): A (2n, 2n), B (2n, n), s = [qd, q]; u (n,) holds it there."""

    q: np.ndarray
    u: np.ndarray
    A: np.ndarray
    B: np.ndarray


def linear_plant(plant: ModelExchangePlant, q: np.ndarray) -> LinearPlant:
    """Linearise an opened plant at rest at q (n,), with the binding's `[linearise]` values and the a-priori others.

    Central differences of its derivatives; the input, in which they are affine, takes a step as large as probing's.
    Raises FmuError where the FMU refuses, or the inputs cannot hold the plant.
    """
    n, chi, rest = plant.n, parameters(plant.binding), np.concatenate([np.zeros(plant.n), q])
    steps = 0.1 * plant.binding.u_range
    B = _differences(lambda u: plant.derivatives(rest, u, chi), np.zeros(n), steps)
    try:
        u = np.linalg.solve(B[:n], -plant.derivatives(rest, np.zeros(n), chi)[:n])
    except np.linalg.LinAlgError:
        raise FmuError(
            f"{plant.file.path.name}: its inputs do not move every joint; check them in the binding"
        ) from None
    M_inverse = B[:n] / plant.binding.gain
    if np.linalg.eigvalsh(M_inverse + M_inverse.T)[0] <= 0.0:
        raise ConfigError(
            f"{plant.file.path.name}: the mass matrix at the a-priori values is not positive definite; correct "
            "a_priori, or the sign of the gain, in the binding"
        )
    A = _differences(lambda s: plant.derivatives(s, u, chi), rest, np.full(2 * n, STATE_STEP))
    return LinearPlant(q, u, A, B)


def parameters(binding: Binding) -> np.ndarray:
    """The parameters (p,) while linearising: a-priori values, those of `[linearise]` in their place."""
    pairs = zip(binding.parameter, binding.a_priori, strict=True)
    return np.array([binding.linearise.get(p.variable or p.name, value) for p, value in pairs])


def _differences(f, x: np.ndarray, steps: np.ndarray) -> np.ndarray:
    return np.column_stack([(f(x + h) - f(x - h)) / (2.0 * h.max()) for h in np.diag(steps)])


def pulse_responses(file: Fmu, settings: ControllerSettings, q: np.ndarray, u_range: np.ndarray) -> np.ndarray:
    """The controller's Markov parameters (n, 2n, SAMPLES) at rest at q (n,), from references and positions to commands.

    Measured as the closed loop runs it: inputs, step, output; the output answers in the sample of the pulse. A second
    pulse of another size, sign and instant must find the same: else it is not linear and time-invariant there, and
    FmuError says so. Reference velocities and extra inputs stay 0.
    """
    responses = []
    for i, direction in enumerate(np.eye(2 * len(q))):
        small = _answer(file, settings, q, PROBE * direction, REST) / PROBE
        peak = np.max(np.abs(small) / u_range)
        size = PULSE / peak if peak > 0.0 else PROBE
        large = _answer(file, settings, q, size * direction, REST + 1) / size
        if np.max(np.abs(large - small)) > TOLERANCE * np.max(np.abs(small)):
            name = (*settings.reference, *settings.position)[i]
            raise ConfigError(
                f"{file.path.name}: not linear in `{name}` at rest at {np.round(q, 3).tolist()}: pulses of {PROBE:g} "
                f"and {size:.2g} get answers that are no multiples of each other; does it saturate there, are "
                "reference and position of the same joint?"
            )
        responses.append(large)
    return np.stack(responses).transpose(2, 0, 1)


def answers_alike(
    file: Fmu, settings: ControllerSettings, q: np.ndarray, u_range: np.ndarray, markov: np.ndarray
) -> bool:
    """Whether the controller at rest at q (n,) has these Markov parameters too, by one pulse on all inputs at once."""
    peak = np.max(np.abs(markov) / u_range[:, None, None], axis=(0, 2))
    pulse = PULSE / len(peak) / np.where(peak > 0.0, peak, np.inf)
    expected = np.einsum("uik,i->ku", markov, pulse)
    return np.max(np.abs(_answer(file, settings, q, pulse, REST) - expected)) <= TOLERANCE * np.max(np.abs(expected))


def _answer(file: Fmu, settings: ControllerSettings, q: np.ndarray, pulse: np.ndarray, at: int) -> np.ndarray:
    """The commands (SAMPLES, n) from sample `at` on, less those at rest at q, to a pulse (2n,) in that sample."""
    start = {**settings.start, **dict(zip(settings.position_start, q, strict=False))}
    start |= dict.fromkeys(settings.velocity_start, 0.0)
    others = np.zeros(len(settings.reference_velocity) + len(settings.extra))
    rest, pulsed = np.concatenate([q, q, others]), np.concatenate([q + pulse[: len(q)], q + pulse[len(q) :], others])
    names = [*settings.reference, *settings.position, *settings.reference_velocity, *settings.extra]
    commands = np.empty((at + SAMPLES, len(q)))
    with Slave(file, start) as slave:
        inlet, outlet = slave.port(names), slave.port(settings.output)
        for k in range(len(commands)):
            inlet.write(pulsed if k == at else rest)
            slave.step(k * settings.period, settings.period)
            commands[k] = outlet.read()
    return commands[at:] - commands[at - 1]
