"""The closed loop: a controller FMU and a plant FMU by Co-Simulation, coupled in one fixed order.

At every sample t_k of the controller:

1. the plant's position q(t_k) and velocity are read;
2. the sensor adds its noise and rounds to the encoder's step (disturbed loop: the controller sees it; clean loop: the
   record alone);
3. the controller gets the reference of t_k and the position, and does its step t_k → t_k + dt: it ticks at the START of
   the step, so its output u_k answers to q(t_k);
4. the plant gets u_k, held over the step (disturbed loop: u_k plus the input noise), and does the same step.

Row k of the frame: t_k, the measured q(t_k), and u_k (clean loop: plus its noise).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np
import pandas as pd

from pipeline.errors import ConfigError, DataError
from pipeline.plant.cosimulation import Slave
from pipeline.plant.fmu import Fmu
from pipeline.simulate import coupling
from pipeline.simulate.sensors import Noise, no_noise

PERIOD_TOLERANCE = 1e-3  # relative, between the reference's samples and the controller's period


@dataclass(frozen=True)
class LoopPorts:
    """The variables that couple the two FMUs, one per joint.

    Of the plant: plant_input, plant_position, plant_velocity. Of the controller: reference, position, output, and where
    it has them reference_velocity and extra (a pulse, for example).
    """

    plant_input: Sequence[str]
    plant_position: Sequence[str]
    plant_velocity: Sequence[str]
    reference: Sequence[str]
    position: Sequence[str]
    output: Sequence[str]
    reference_velocity: Sequence[str] = ()
    extra: Sequence[str] = ()


def simulate_closed_loop(
    plant: Fmu | str | PathLike,
    controller: Fmu | str | PathLike,
    ports: LoopPorts,
    reference: pd.DataFrame,
    period: float,
    noise: Noise | None = None,
    plant_start: Mapping[str, float] | None = None,
    controller_start: Mapping[str, float] | None = None,
    gain: Sequence[float] | None = None,
    engine: str = "python",
) -> pd.DataFrame:
    """Run the loop over a reference and return the measured frame with the truth beside it.

    reference: index `time` s in steps of `period` (s), columns qr_i, and qdr_i, pulse_i where the controller has such
    inputs (a pulse that is absent is 0). start values: by variable name. gain (n,): tau = gain·u (default 1).
    engine: "compiled", or any other for Python; they give the same bits.
    The frame: q_i, u_i, tau_i as measured; the reference's columns; q_true_i, qd_true_i, tau_true_i.
    Raises FmuError for a simulation that fails, DataError or ConfigError for a reference that does not fit.
    """
    n, N = len(ports.plant_input), len(reference)
    noise = noise or no_noise(N, n)
    if len(noise.position) < N:
        raise ConfigError(f"noise: {len(noise.position)} samples for a reference of {N}; draw at least as many")
    t = _instants(reference, period)
    inputs = controller_inputs(ports, reference)
    in_loop = float(noise.loop == "disturbed")
    with Slave(plant, plant_start, t[0]) as robot, Slave(controller, controller_start, t[0]) as law:
        states = robot.port([*ports.plant_position, *ports.plant_velocity])
        sensed = law.port([*ports.reference, *ports.reference_velocity, *ports.extra, *ports.position])
        output, drive = law.port(ports.output), robot.port(ports.plant_input)
        state, q, u = _coupling(engine).couple(states, sensed, output, drive, t, period, inputs, noise)
    gain = np.ones(n) if gain is None else np.asarray(gain, float)
    measured_u = u + (1.0 - in_loop) * noise.input[:N]
    columns = {"q": q, "u": measured_u, "tau": gain * measured_u}
    truth = {"q_true": state[:, :n], "qd_true": state[:, n:], "tau_true": gain * (u + in_loop * noise.input[:N])}
    return pd.concat([_frame(columns, reference.index), reference, _frame(truth, reference.index)], axis=1)


def simulate_closed_loop_fmu(
    loop: Fmu | str | PathLike,
    inputs: Mapping[str, str],
    sampled: Mapping[str, str],
    held: Mapping[str, str],
    reference: pd.DataFrame,
    period: float,
    start: Mapping[str, float] | None = None,
    engine: str = "python",
) -> pd.DataFrame:
    """Run a closed loop that is one FMU, sampled at the same instants as `simulate_closed_loop`.

    inputs: its input variables by the reference's column; sampled: variables by frame column, read at t_k before
    the step (positions, velocities); held: read after it, since they hold over the step (the controller's output).
    """
    t = _instants(reference, period)
    values = reference[list(inputs)].to_numpy(float)
    with Slave(loop, start, t[0]) as slave:
        before, inlet, after = (slave.port([*names.values()]) for names in (sampled, inputs, held))
        found = _coupling(engine).follow(before, inlet, after, t, period, values)
    return pd.DataFrame(np.hstack(found), index=reference.index, columns=[*sampled, *held])


def _coupling(engine: str):
    """The module that couples slaves: on kernels, or in Python."""
    if engine == "compiled":
        from pipeline.simulate import coupling_compiled  # numba is slow to import

        return coupling_compiled
    return coupling


def controller_inputs(ports: LoopPorts, reference: pd.DataFrame) -> np.ndarray:
    """The controller's inputs over time (N, m): references, their velocities, extras (0 where the frame has none)."""
    groups = (("qr", ports.reference), ("qdr", ports.reference_velocity), ("pulse", ports.extra))
    columns = []
    for name, variables in groups:
        for i in range(1, len(variables) + 1):
            if f"{name}_{i}" in reference:
                columns.append(reference[f"{name}_{i}"].to_numpy(float))
            elif name == "pulse":
                columns.append(np.zeros(len(reference)))
            else:
                raise DataError(f"reference: no column `{name}_{i}`, which the controller needs; map it from the data")
    return np.column_stack(columns)


def _instants(reference: pd.DataFrame, period: float) -> np.ndarray:
    """The communication points t_0 + k·period (N,) s; refuses a reference of another sample period."""
    index = reference.index.to_numpy(float)
    if len(index) < 2:
        raise DataError(f"reference: {len(index)} samples; a closed loop needs at least 2")
    found = (index[-1] - index[0]) / (len(index) - 1)
    if abs(found / period - 1.0) > PERIOD_TOLERANCE:
        raise ConfigError(
            f"reference: a sample every {found:.6g} s, the controller's period is {period:g} s; make them one"
        )
    return index[0] + period * np.arange(len(index))


def _frame(groups: Mapping[str, np.ndarray], index: pd.Index) -> pd.DataFrame:
    columns = {f"{name}_{i + 1}": values[:, i] for name, values in groups.items() for i in range(values.shape[1])}
    return pd.DataFrame(columns, index=index)
