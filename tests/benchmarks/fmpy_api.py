"""What a user would write on fmpy's public Python API: an EKF with filterpy, and a loop of two slaves."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from ctypes import POINTER, c_double
from pathlib import Path

import fmpy
import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.model_description import ModelDescription

from pipeline.plant.binding import Binding
from pipeline.plant.steps import EPSILON
from pipeline.simulate.closed_loop import LoopPorts
from tests.benchmarks.record import Record


@contextmanager
def unpacked(path: Path) -> Iterator[tuple[ModelDescription, str]]:
    """An FMU's description and its unpacked folder."""
    folder = fmpy.extract(str(path))
    try:
        yield fmpy.read_model_description(str(path)), folder
    finally:
        shutil.rmtree(folder)


@contextmanager
def instance(
    kind: type, description: ModelDescription, folder: str, start: Mapping[str, float]
) -> Iterator[tuple[FMU2Model | FMU2Slave, dict[str, int]]]:
    """An initialised FMI 2.0 instance, FMU2Model or FMU2Slave, and its value references by name."""
    references = {v.name: v.valueReference for v in description.modelVariables}
    interface = description.modelExchange if kind is FMU2Model else description.coSimulation
    fmu = kind(guid=description.guid, unzipDirectory=folder, modelIdentifier=interface.modelIdentifier)
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.setReal(_references(references, start), list(start.values()))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    yield fmu, references
    fmu.freeInstance()


class UserPlant:
    """The plant by Model Exchange: Euler's transition, parameters set in Event Mode where they change.

    The FMU's states are q and qd in this order, as those of our SCARA are.
    """

    def __init__(self, fmu: FMU2Model, references: Mapping[str, int], binding: Binding):
        self.fmu, self.n = fmu, binding.n
        self.inputs = [references[j.input] for j in binding.joint]
        self.parameters = [references[p.variable or p.name] for p in binding.parameter]
        self.x, self.dx = np.zeros(2 * self.n), np.zeros(2 * self.n)
        self.x_pointer, self.dx_pointer = (a.ctypes.data_as(POINTER(c_double)) for a in (self.x, self.dx))
        self.chi = None
        fmu.enterContinuousTimeMode()

    def transition(self, z: np.ndarray, u: np.ndarray, dt: float) -> np.ndarray:
        """[qd, q] after dt (s), from z = [qd, q, chi]."""
        n, fmu = self.n, self.fmu
        if not np.array_equal(self.chi, z[2 * n :]):
            self.chi = z[2 * n :].copy()
            fmu.enterEventMode()
            fmu.setReal(self.parameters, self.chi)
            fmu.newDiscreteStates()
            fmu.enterContinuousTimeMode()
        fmu.setReal(self.inputs, u)
        self.x[:n], self.x[n:] = z[n : 2 * n], z[:n]
        fmu.setContinuousStates(self.x_pointer, 2 * n)
        fmu.getDerivatives(self.dx_pointer, 2 * n)
        return z[: 2 * n] + dt * np.concatenate([self.dx[n:], self.dx[:n]])


def user_ekf(plant: UserPlant, record: Record, u_range: np.ndarray) -> np.ndarray:
    """The filtered states (N, nx): filterpy's EKF, forward differences by z and u through the FMU."""
    r, n, nx = record, plant.n, len(record.z0)
    H = np.zeros((n, nx))
    H[:, n : 2 * n] = np.eye(n)
    ekf = ExtendedKalmanFilter(dim_x=nx, dim_z=n)
    ekf.x, ekf.P, ekf.R = r.z0.copy(), r.P0.copy(), np.diag(r.tuning.R)
    ekf.predict_x = lambda u=0: None  # the plant has predicted x
    x = np.empty((len(r.time), nx))
    for k in range(len(r.time)):
        if k:
            plant.fmu.setTime(r.time[k - 1])
            _predict(ekf, plant, r, u_range, r.u[k - 1], r.time[k] - r.time[k - 1])
        ekf.update(r.q[k], lambda x: H, lambda x: H @ x)
        x[k] = ekf.x
    return x


def _predict(ekf, plant: UserPlant, record: Record, u_range: np.ndarray, u: np.ndarray, dt: float) -> None:
    ns, nx = 2 * plant.n, len(ekf.x)
    f = plant.transition(ekf.x, u, dt)
    F, G = np.eye(nx), np.zeros((nx, len(u)))
    for i, step in enumerate(EPSILON["forward"] * np.maximum(np.abs(ekf.x), record.scale)):
        there = ekf.x.copy()
        there[i] += step
        F[:ns, i] = (plant.transition(there, u, dt) - f) / (there[i] - ekf.x[i])
    for i, step in enumerate(EPSILON["forward"] * np.maximum(np.abs(u), u_range)):
        there = u.copy()
        there[i] += step
        G[:ns, i] = (plant.transition(ekf.x, there, dt) - f) / (there[i] - u[i])
    ekf.x = np.concatenate([f, ekf.x[ns:]])
    ekf.F, ekf.Q = F, (G * record.tuning.q) @ G.T
    ekf.predict()


def user_loop(
    plant: tuple[FMU2Slave, Mapping], controller: tuple[FMU2Slave, Mapping], ports: LoopPorts, reference, t, dt: float
) -> np.ndarray:
    """Positions, velocities and inputs (N, 3 n), coupled in the order of pipeline/simulate/closed_loop.py.

    plant, controller: initialised slaves with their references; reference (N, m): the controller's inputs but for the
    positions; t (N,) s the communication points.
    """
    (robot, of_robot), (pd_law, of_law) = plant, controller
    n = len(ports.plant_input)
    states = _references(of_robot, (*ports.plant_position, *ports.plant_velocity))
    drive = _references(of_robot, ports.plant_input)
    sensed = _references(of_law, (*ports.reference, *ports.reference_velocity, *ports.extra, *ports.position))
    output = _references(of_law, ports.output)
    rows = []
    for k in range(len(t)):
        state = robot.getReal(states)
        pd_law.setReal(sensed, [*reference[k], *state[:n]])
        pd_law.doStep(currentCommunicationPoint=t[k], communicationStepSize=dt)
        u = pd_law.getReal(output)
        robot.setReal(drive, u)
        robot.doStep(currentCommunicationPoint=t[k], communicationStepSize=dt)
        rows.append([*state, *u])
    return np.array(rows)


def _references(known: Mapping[str, int], names: Iterable[str]) -> list[int]:
    return [known[name] for name in names]
