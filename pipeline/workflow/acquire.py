"""The data stage: the measured frame, from the closed loop of two FMUs or from a measured file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.errors import DataError
from pipeline.plant.binding import Binding
from pipeline.settings import Column
from pipeline.signals.cutoffs import check_border
from pipeline.simulate.closed_loop import LoopPorts, simulate_closed_loop
from pipeline.simulate.measured import FRAME_COLUMN, ColumnSettings, read_measured, with_force
from pipeline.simulate.sensors import draw_noise
from pipeline.simulate.trajectory import Limits, check_limits, read_waypoints, reference_frame, sample
from pipeline.workflow.engine import loop_engine
from pipeline.workflow.session import Session

MIN_SAMPLES = 200


def acquire(session: Session, validation: bool = False) -> pd.DataFrame:
    """The measured frame of the identification run, or of the validation run."""
    if session.measured:
        return read(session, validation)
    return simulate(session, validation)


def simulate(session: Session, validation: bool = False, noisy: bool = True) -> pd.DataFrame:
    """Simulate the closed loop on a stored trajectory; the noise follows from seed and run alone."""
    settings = session.experiment.simulation
    reference = reference_of(session, validation)
    check_borders(session, len(reference))
    scale = 1.0 if noisy else 0.0
    rng = np.random.default_rng([session.experiment.seed, int(validation)])
    sigma_q, sigma_u, quantum = (scale * np.array(s) for s in (settings.sigma_q, settings.sigma_u, settings.quantum_q))
    noise = draw_noise(rng, len(reference), sigma_q, sigma_u, settings.loop, quantum)
    return run_loop(session, reference, session.truth, noise)


def reference_of(session: Session, validation: bool = False) -> pd.DataFrame:
    """The stored trajectory as the controller's reference, sampled at the data's rate.

    Raises DataError where it leaves the limits of [excitation] (those of tau were checked as it was designed).
    """
    path, limits = _waypoints(session)[validation], session.experiment.excitation
    waypoints = read_waypoints(path)
    if limits is not None:
        try:
            check_limits(waypoints, Limits(limits.q, limits.qd, limits.qdd))
        except DataError as error:
            raise DataError(f"{path.name}: {error} in [excitation]") from None
    return reference_frame(sample(waypoints, session.experiment.simulation.rate))


def run_loop(session: Session, reference: pd.DataFrame, chi: np.ndarray, noise=None, qd_start=None) -> pd.DataFrame:
    """The closed loop with plant parameters chi (p,), started on the reference's (or the record's) first position.

    reference: as `simulate_closed_loop` wants it; where it holds a measured `q_i`, the loop starts there.
    """
    binding, controller = session.binding, session.experiment.controller
    n = binding.n
    first = reference.iloc[0]
    q_start = [first[f"q_{i}" if f"q_{i}" in first else f"qr_{i}"] for i in range(1, n + 1)]
    qd_start = np.zeros(n) if qd_start is None else qd_start
    plant_start = {**binding.start_values(chi), **binding.filter}
    plant_start |= dict(zip((j.position_start for j in binding.joint), q_start, strict=True))
    plant_start |= dict(zip((j.velocity_start for j in binding.joint), qd_start, strict=True))
    controller_start = {**controller.start, **dict(zip(controller.position_start, q_start, strict=False))}
    controller_start |= dict(zip(controller.velocity_start, qd_start, strict=False))
    columns = [c for c in reference if c.startswith(("qr_", "qdr_", "pulse_"))]

    def simulated(engine: str, samples: int | None = None) -> pd.DataFrame:
        return simulate_closed_loop(
            binding.path,
            session.controller_fmu,
            ports_of(session),
            reference[columns].iloc[:samples],
            controller.period,
            noise,
            plant_start,
            controller_start,
            binding.gain,
            engine,
        )

    return simulated(loop_engine(session, lambda engine, samples: simulated(engine, samples).to_numpy()))


def ports_of(session: Session) -> LoopPorts:
    """The variables that couple plant and controller."""
    joints, controller = session.binding.joint, session.experiment.controller
    return LoopPorts(
        plant_input=[j.input for j in joints],
        plant_position=[j.position for j in joints],
        plant_velocity=[j.velocity for j in joints],
        reference=controller.reference,
        position=controller.position,
        output=controller.output,
        reference_velocity=controller.reference_velocity,
        extra=controller.extra,
    )


def read(session: Session, validation: bool = False) -> pd.DataFrame:
    """Read the measured run; DataError where the data are not there says where to get them."""
    data, path = session.experiment.data, data_files(session)[validation]
    check_file(session, path)
    columns = {**data.columns, **(data.validation_columns if validation else {})}
    units = frame_units(session.binding)
    mapped = {name: _mapped(session, name, column, units) for name, column in columns.items()}
    offered = {name: unit for name, unit in units.items() if name == "time" or FRAME_COLUMN.fullmatch(name)}
    frame = read_measured(
        path, mapped, data.rate, MIN_SAMPLES, units=offered, delimiter=data.delimiter, decimal=data.decimal
    )
    frame = with_force(frame, session.binding.gain)
    check_borders(session, len(frame))
    return frame


def check_borders(session: Session, samples: int) -> None:
    """Refuse a border that leaves nothing of a record of `samples`, before the work begins; ConfigError."""
    loop = session.experiment.closed_loop
    borders = {w.name: w.border for w in session.experiment.wls}
    for name, border in {**borders, **({"closed_loop": loop.border} if loop else {})}.items():
        check_border(name, border, samples)


def check_file(session: Session, path: Path) -> None:
    """Refuse a data file that is not there (DataError, with where to get it)."""
    if path.is_file():
        return
    data = session.experiment.data
    if data is None:
        raise DataError(f"{path}: no such file; correct the path of the way-points")
    hint = f"get it from {data.source}, then give" if data.source else "give"
    raise DataError(f"{path.name}: no such data file in {path.parent}; {hint} its folder with --data")


def data_files(session: Session) -> tuple[Path, Path]:
    """The files of the identification and the validation run: measured data, or the way-points of a simulation.

    Measured files are in `--data` as the shell knows it, or in the experiment's own folder setting.
    """
    data = session.experiment.data
    if data is None:
        return _waypoints(session)
    folder = session.data or session.folder / data.folder
    return folder / data.identification, folder / data.validation


def _waypoints(session: Session) -> tuple[Path, Path]:
    simulation = session.experiment.simulation
    return session.folder / simulation.identification, session.folder / simulation.validation


def frame_units(binding: Binding) -> dict[str, str]:
    """The unit of each column that a measured frame may have, `time` among them."""
    units = {"time": "s"}
    for i, joint in enumerate(binding.joint, start=1):
        units |= {f"{name}_{i}": joint.position_unit for name in ("q", "qr", "q_true")}
        units |= {f"{name}_{i}": joint.velocity_unit for name in ("qd", "qdr", "qd_true")}
        units |= {f"{name}_{i}": joint.input_unit for name in ("u", "pulse")}
        units |= {f"{name}_{i}": joint.force_unit for name in ("tau", "tau_true")}
    return units


def _mapped(session: Session, name: str, column: Column, units: dict[str, str]) -> ColumnSettings:
    """The column with the unit it is converted to: the binding's, by what the column is."""
    joint = name.rpartition("_")[2]
    if name != "time" and (not joint.isdigit() or not 1 <= int(joint) <= session.binding.n):
        raise DataError(f"data column `{name}`: the plant has joints 1 to {session.binding.n}; name one of them")
    return ColumnSettings(column.source, column.unit, units.get(name, ""), column.scale, column.offset)
