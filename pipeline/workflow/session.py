"""An experiment opened: its settings, its binding, and the clock that times its stages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from difflib import get_close_matches
from os.path import splitext
from pathlib import Path
from time import process_time

import numpy as np
from msgspec import structs

from pipeline.config import find_experiment, load_experiment
from pipeline.errors import ConfigError
from pipeline.export.catalogue import exported
from pipeline.paths import BINDINGS, MODELICA, built_fmu
from pipeline.plant.binding import Binding, load_binding, variants_of_bindings
from pipeline.settings import Experiment, WlsSettings
from pipeline.signals.cutoffs import check_cutoffs, follows_loop
from pipeline.simulate.closed_loop import PERIOD_TOLERANCE
from pipeline.simulate.sensors import position_variance


@dataclass(frozen=True)
class EngineChoice:
    """The engine `used`, "compiled", "python" or "filterpy"; reason: why it is not the one asked for."""

    used: str
    reason: str = ""

    @property
    def text(self) -> str:
        """One line for people."""
        words = {"compiled": "compiled", "python": "Python", "filterpy": "filterpy, in the Joseph form"}
        return f"{words[self.used]} ({self.reason})" if self.reason else words[self.used]


@dataclass(frozen=True)
class Session:
    """What every stage needs: the settings, the binding, the folder that paths are relative to.

    narrate: called with a line for the user as each stage ends; data: the folder of the measured files, where the
    user gave one; stages: CPU seconds by stage; engines: what computes, by part.
    """

    experiment: Experiment
    binding: Binding
    folder: Path
    data: Path | None = None
    narrate: Callable[[str], None] = lambda text: None
    stages: dict[str, float] = field(default_factory=dict)
    engines: dict[str, EngineChoice] = field(default_factory=dict)

    @property
    def rate(self) -> float:
        """The sample rate of the data in Hz."""
        return (self.experiment.data or self.experiment.simulation).rate

    @property
    def measured(self) -> bool:
        """Whether the data are measured, not simulated."""
        return self.experiment.data is not None

    @property
    def recommended(self) -> WlsSettings:
        """The WLS variant that everything else builds on."""
        return next(w for w in self.experiment.wls if w.name == self.experiment.recommended)

    @property
    def controller_fmu(self) -> Path | None:
        """The controller's FMU: one of ours by name, or a path relative to the experiment; None without controller."""
        if self.experiment.controller is None:
            return None
        name = self.experiment.controller.fmu
        return self.folder / name if name.endswith(".fmu") else built_fmu(name, self.experiment.fmi)

    @property
    def truth(self) -> np.ndarray | None:
        """The true parameters (p,) of a simulated plant, or None."""
        if self.measured:
            return None
        return np.array([self.experiment.simulation.truth[name] for name in self.binding.names])

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time a stage by CPU seconds and say so when it is done."""
        start = process_time()
        yield
        self.stages[name] = self.stages.get(name, 0.0) + process_time() - start
        self.narrate(f"  {name:<22}{self.stages[name]:7.2f} s CPU")


def open_session(
    name_or_path: str,
    overrides=(),
    narrate: Callable[[str], None] = lambda text: None,
    simulated: bool = False,
    data: str | None = None,
) -> Session:
    """Load an experiment with `--set` overrides and its binding, and hold one against the other. Raises ConfigError.

    simulated: leave measured data aside and use the experiment's [simulation]; data: the folder of the measured files.
    """
    experiment = load_experiment(name_or_path, overrides, without=("data",) if simulated else ())
    folder = find_experiment(name_or_path).parent
    if data is not None and experiment.data is None:
        raise ConfigError(f"{experiment.name}: simulates its data, so --data has no use; add [data] or leave it out")
    binding = _ours(load_binding(experiment.plant, folder), experiment.fmi)
    session = Session(experiment, binding, folder, None if data is None else Path(data), narrate)
    _check_sizes(session)
    _check_filters(session)
    _check_period(session)
    return session


def our_fmus() -> list[str]:
    """Names of the FMUs that `fmuid build` makes."""
    return [*exported(MODELICA), *variants_of_bindings()]


def _ours(binding: Binding, fmi: str) -> Binding:
    """The binding with its FMU where `fmuid build` puts it, if it is a binding of ours, to an FMU of ours."""
    name, suffix = splitext(binding.fmu)
    if Path(binding.folder) != BINDINGS or suffix != ".fmu" or name not in our_fmus():
        return binding
    file = built_fmu(name, fmi)
    return structs.replace(binding, folder=str(file.parent), fmu=file.name)


def _check_period(session: Session) -> None:
    """The controller acts on every sample of the data: its loop, and the cut-offs that follow it, rest on that."""
    controller = session.experiment.controller
    if controller is not None and abs(controller.period * session.rate - 1.0) > PERIOD_TOLERANCE:
        raise ConfigError(
            f"{session.experiment.name}: controller.period is {controller.period:g} s, but the data come every "
            f"{1.0 / session.rate:g} s ({session.rate:g} Hz); make them one"
        )


def _check_filters(session: Session) -> None:
    """Cut-offs that are set must fit the data's rate; those that are not need a closed loop to follow."""
    for settings in session.experiment.wls:
        check_cutoffs(settings, session.rate)
        if follows_loop(settings) and session.experiment.controller is None:
            raise ConfigError(
                f"{session.experiment.name}: {settings.name}: a filter without `cutoff` follows the closed loop, and "
                "there is no [controller]; set the cut-off in Hz (position: about 5 times the loop's bandwidth, "
                "parallel: 2 times), or add [controller]"
            )


def _check_sizes(session: Session) -> None:
    """One entry per joint, state or parameter, wherever an experiment lists them."""
    e, n, p = session.experiment, session.binding.n, len(session.binding.names)
    sized = []
    if e.controller is not None:
        c = e.controller
        sized = [(f"controller.{key}", getattr(c, key), n) for key in ("reference", "position", "output")]
        optional = ("reference_velocity", "extra", "position_start", "velocity_start")
        sized += [(f"controller.{key}", getattr(c, key), n) for key in optional if getattr(c, key)]
    if e.simulation is not None:
        sized += [("simulation.sigma_q", e.simulation.sigma_q, n), ("simulation.sigma_u", e.simulation.sigma_u, n)]
        if e.simulation.quantum_q:
            sized.append(("simulation.quantum_q", e.simulation.quantum_q, n))
        _check_truth(session)
    if e.excitation is not None:
        sized += [(f"excitation.{key}", getattr(e.excitation, key), n) for key in ("q", "qd", "qdd", "tau")]
        optional = [key for key in ("sigma_tau", "slow") if getattr(e.excitation, key)]
        sized += [(f"excitation.{key}", getattr(e.excitation, key), n) for key in optional]
    if e.ekf is not None:
        sized.append(("ekf.P0_state", e.ekf.P0_state, 2 * n))
        for case in e.ekf.case:
            sized += [
                (f"{case.name}: {key}", value, size)
                for key, value, size in (
                    ("chi0", case.chi0, p),
                    ("P0_parameters", case.P0_parameters, p),
                    ("P0_state", case.P0_state, 2 * n),
                    ("R", case.R, n),
                    ("Q", case.Q, 2 * n),
                )
                if value
            ]
    for key, value, size in sized:
        if len(value) != size:
            raise ConfigError(f"{e.name}: {key} has {len(value)} entries, the plant asks for {size}; give {size}")
    _check_known_noise(e)


def _check_truth(session: Session) -> None:
    """The true parameters are the binding's, one by one."""
    truth, names = session.experiment.simulation.truth, session.binding.names
    for name in sorted(set(truth) - set(names)):
        near = get_close_matches(name, names, n=1, cutoff=0.0)[0]
        raise ConfigError(f"{session.experiment.name}: simulation.truth: no parameter `{name}`; nearest: `{near}`")
    for name in sorted(set(names) - set(truth)):
        raise ConfigError(f"{session.experiment.name}: simulation.truth lacks `{name}`; give its value")


def _check_known_noise(e: Experiment) -> None:
    """The tuning `known` takes R from the sensors: one that measures exactly would make it 0."""
    if not any("known" in case.tunings for case in (e.ekf.case if e.ekf else ())):
        return
    exact = np.flatnonzero(position_variance(e.simulation.sigma_q, e.simulation.quantum_q) == 0.0)
    if exact.size:
        raise ConfigError(
            f"{e.name}: the tuning `known` needs noise on every position, joint {exact[0] + 1} has none; set "
            "simulation.sigma_q or quantum_q above 0, or leave out `known`"
        )
