"""The planar chain of n links (modelica: Plants.Chain): what is known of it beforehand, and its binding."""

from pathlib import Path

import numpy as np

from pipeline.config import convert
from pipeline.plant.binding import Binding

EPS = 0.1  # rad/s: while the filter runs
UNITS = {"ZZ": "kg.m2", "MX": "kg.m", "Fv": "N.m.s/rad", "Fs": "N.m"}


def a_priori(n: int) -> dict[str, np.ndarray]:
    """ZZ, MX, Fv, Fs (n,) each: rods of 2 kg and 0.5 m, those behind them regrouped."""
    behind = np.arange(n - 1, -1, -1)
    return {
        "ZZ": 0.5 * (1 / 3 + behind),
        "MX": 0.5 + behind,
        "Fv": np.full(n, 0.1),
        "Fs": np.full(n, 0.2),
    }


def chain_table(n: int, fmu: str) -> dict:
    """The binding as a table: parameters ZZ[1] … ZZ[n], MX[1] …, Fv[1] …, Fs[1] … (4 n)."""
    units = {"input_unit": "N.m", "force_unit": "N.m", "position_unit": "rad", "velocity_unit": "rad/s"}
    names = {"position": "q[{}]", "velocity": "qd[{}]", "position_state": "body.q[{}]", "velocity_state": "body.qd[{}]"}
    names |= {"input": "tau[{}]", "position_start": "q_start[{}]", "velocity_start": "qd_start[{}]", "name": "joint {}"}
    joints = [{key: name.format(i) for key, name in names.items()} | units | {"u_range": 10.0} for i in range(1, n + 1)]
    parameters = [
        {"name": f"{name}[{i}]", "unit": UNITS[name], "a_priori": float(value), "scale": 0.1}
        for name, values in a_priori(n).items()
        for i, value in enumerate(values, start=1)
    ]
    still = {f"Fs[{i}]": 0.0 for i in range(1, n + 1)}
    tables = {"probe": {"eps": 1e-9}, "filter": {"eps": EPS}, "linearise": still}
    return {"fmu": fmu, **tables, "joint": joints, "parameter": parameters}


def chain_binding(n: int, fmu_path: Path) -> Binding:
    """The binding of a built chain, in no file: those in `fmus/` are the project's plants."""
    path = Path(fmu_path)
    return convert({"folder": str(path.parent), **chain_table(n, path.name)}, Binding, path.name)
