"""The filter of `ekf.py` on its kernel: arrays in, a FilterRun out."""

from __future__ import annotations

import numpy as np

from pipeline.errors import FmuError
from pipeline.identify import udu
from pipeline.identify.covariance_forms import P_LOST
from pipeline.identify.ekf import MASS_LOST, NOT_A_NUMBER, Tuning
from pipeline.identify.ekf_kernel import NO_MASS, NOT_FINITE, NOT_POSITIVE, PLANT_FAILED, filter_fields, run
from pipeline.interrupts import STOP, raise_kept
from pipeline.plant.compiled import CompiledPlant
from pipeline.plant.memory import Memory
from pipeline.records import FilterRun

CHUNK = 250
"""Samples at a time: between them an interrupt is seen."""

REASONS = {NO_MASS: MASS_LOST, NOT_FINITE: NOT_A_NUMBER, NOT_POSITIVE: P_LOST}


def run_compiled(
    plant: CompiledPlant,
    time: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    z0: np.ndarray,
    P0: np.ndarray,
    tuning: Tuning,
    jacobian: str,
    covariance: str,
) -> FilterRun:
    """`run_filter`, compiled; its arguments and its result."""
    memory = _memory(plant, time, q, u, z0, tuning, jacobian)
    done, reason, samples = 0, "", len(time)
    try:
        _start(memory, P0, covariance)
        while done < samples and not reason:
            end = min(done + CHUNK, samples)
            done, how = run(plant.memory.record, memory.record, done, end)
            raise_kept()
            plant.check(how == PLANT_FAILED, float(time[max(done - 1, 0)]))
            reason = REASONS.get(how, "")
    except (FmuError, np.linalg.LinAlgError) as error:
        reason = str(error)
    found = (memory[name][:done] for name in ("x", "P_diag", "innovation", "S_diag", "NIS"))
    return FilterRun(time[:done], *found, P0 if reason else _covariance(memory), done if reason else None, reason)


def _memory(plant: CompiledPlant, time, q, u, z0, tuning: Tuning, jacobian: str) -> Memory:
    """The kernel's record, all in it but the covariance."""
    n, ns, nx, N, nq = plant.n, plant.ns, len(z0), len(time), len(tuning.q)
    mode, central, epsilon = plant.begin(jacobian)
    memory = Memory(filter_fields(n, ns, nx - ns, nq))
    memory.set(input_noise=tuning.input_noise, mode=mode, central=central)
    memory.set(epsilon=epsilon, z=z0, R=tuning.R, noise=tuning.q, G=np.eye(nq, ns))
    memory.put(stop=STOP, time=np.array(time, float), q=np.array(q, float), u=np.array(u, float))
    memory.put(x=np.zeros((N, nx)), P_diag=np.zeros((N, nx)), NIS=np.zeros(N))
    memory.put(innovation=np.zeros((N, n)), S_diag=np.zeros((N, n)))
    return memory


def _start(memory: Memory, P0: np.ndarray, covariance: str) -> None:
    """P0 (nx, nx) itself, or its factors: Uᵀ and d. LinAlgError where it has none."""
    memory.set(udu=covariance == "udu")
    if covariance == "udu":
        U, d = udu.factor(P0)
        memory.set(P=U.T, d=d)
    else:
        memory.set(P=P0)


def _covariance(memory: Memory) -> np.ndarray:
    return udu.covariance(memory["P"].T, memory["d"]) if memory["udu"] else memory["P"].copy()
