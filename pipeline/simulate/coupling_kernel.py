"""The samples of a closed loop, compiled: `coupling.py`, in the same order."""

from __future__ import annotations

import numpy as np

from pipeline.plant.kernel import array_at, kernel, matrix_at
from pipeline.plant.slave_kernel import read, step, write

LOOP = [
    *((name, "i8") for name in (
        "n", "m", "disturbed",
        # communication points t (N,); the controller's inputs but for the positions (N, m); what is added to positions
        # and plant inputs (N, n); the encoders' steps (n,), 0 for none
        "t", "inputs", "position_noise", "input_noise", "quantum",
        # what is found: the plant's positions and velocities (N, 2n), the measured positions and the outputs (N, n)
        "state", "q", "u",
    )),
    ("dt", "f8"),
]  # fmt: skip
"""Fields of the record of a loop of two slaves."""

FOLLOWED = [
    *((name, "i8") for name in ("n_inlet", "n_before", "n_after", "t", "inputs", "before", "after")),
    ("dt", "f8"),
]
"""Fields of the record of a loop that is one slave: inputs (N, n_inlet), what is read before and after each step."""

STATES, SENSED, CONTROLLER_STEP, OUTPUT, DRIVE, PLANT_STEP = range(6)
BEFORE, INLET, STEP, AFTER = range(4)
DONE = -1
"""Where a sample failed, in its order; or that none did."""


@kernel
def shown(q, noise, quantum):
    """What an encoder shows of the position q: `Noise.measured`."""
    noisy = q + noise
    return np.rint(noisy / quantum) * quantum if quantum > 0.0 else noisy


@kernel
def couple(plant, controller, states, sensed, output, drive, loop, first, end):
    """Run samples first … end − 1; gives where it failed, or DONE."""
    robot, law, w = plant[0], controller[0], loop[0]
    n, m, t, quantum = w.n, w.m, array_at(w.t, end), array_at(w.quantum, w.n)
    seen, given = array_at(states[0].values, 2 * n), array_at(sensed[0].values, m + n)
    command, driven = array_at(output[0].values, n), array_at(drive[0].values, n)
    noise, push = matrix_at(w.position_noise, end, n), matrix_at(w.input_noise, end, n)
    inputs = matrix_at(w.inputs, end, m)
    state, q, u = matrix_at(w.state, end, 2 * n), matrix_at(w.q, end, n), matrix_at(w.u, end, n)
    for k in range(first, end):
        if read(robot, states[0]):
            return STATES
        for i in range(2 * n):
            state[k, i] = seen[i]
        for i in range(n):
            q[k, i] = shown(seen[i], noise[k, i], quantum[i])
            given[m + i] = q[k, i] if w.disturbed else seen[i]
        for i in range(m):
            given[i] = inputs[k, i]
        if write(law, sensed[0]):
            return SENSED
        if step(law, t[k], w.dt):
            return CONTROLLER_STEP
        if read(law, output[0]):
            return OUTPUT
        for i in range(n):
            u[k, i] = command[i]
            driven[i] = command[i] + push[k, i]
        if write(robot, drive[0]):
            return DRIVE
        if step(robot, t[k], w.dt):
            return PLANT_STEP
    return DONE


@kernel
def follow(slave, before, inlet, after, loop, first, end):
    """The same for a loop that is one slave."""
    one, w = slave[0], loop[0]
    t, inputs, given = array_at(w.t, end), matrix_at(w.inputs, end, w.n_inlet), array_at(inlet[0].values, w.n_inlet)
    seen, held = array_at(before[0].values, w.n_before), array_at(after[0].values, w.n_after)
    found, kept = matrix_at(w.before, end, w.n_before), matrix_at(w.after, end, w.n_after)
    for k in range(first, end):
        if read(one, before[0]):
            return BEFORE
        for i in range(w.n_before):
            found[k, i] = seen[i]
        for i in range(w.n_inlet):
            given[i] = inputs[k, i]
        if write(one, inlet[0]):
            return INLET
        if step(one, t[k], w.dt):
            return STEP
        if read(one, after[0]):
            return AFTER
        for i in range(w.n_after):
            kept[k, i] = held[i]
    return DONE
