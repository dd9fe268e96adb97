"""The samples of a closed loop, one by one, in the order that `closed_loop.py` tells."""

from __future__ import annotations

import numpy as np

from pipeline.plant.cosimulation import Port
from pipeline.simulate.sensors import Noise


def couple(
    states: Port, sensed: Port, output: Port, drive: Port, t: np.ndarray, dt: float, inputs: np.ndarray, noise: Noise
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Couple two slaves at t (N,) s: state (N, 2n) of the plant, measured q (N, n), the controller's output u (N, n).

    states and drive are the plant's ports, sensed and output the controller's; inputs (N, m) what it gets beside the
    positions. Raises FmuError.
    """
    robot, law, (N, n) = states.slave, sensed.slave, (len(t), len(drive.names))
    state, q, u = np.empty((N, 2 * n)), np.empty((N, n)), np.empty((N, n))
    in_loop = noise.loop == "disturbed"
    drive_noise = float(in_loop) * noise.input
    for k in range(N):
        state[k] = states.read()
        q[k] = noise.measured(state[k, :n], k)
        sensed.write(np.concatenate([inputs[k], q[k] if in_loop else state[k, :n]]))
        law.step(t[k], dt)
        u[k] = output.read()
        drive.write(u[k] + drive_noise[k])
        robot.step(t[k], dt)
    return state, q, u


def follow(
    before: Port, inlet: Port, after: Port, t: np.ndarray, dt: float, inputs: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Drive one slave by inputs (N, m) at t (N,) s: what is read before each step and after it. Raises FmuError."""
    seen, held = np.empty((len(t), len(before.names))), np.empty((len(t), len(after.names)))
    for k in range(len(t)):
        seen[k] = before.read()
        inlet.write(inputs[k])
        inlet.slave.step(t[k], dt)
        held[k] = after.read()
    return seen, held
