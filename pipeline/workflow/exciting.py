"""The design of an experiment's trajectory: search, then check the plan at 1 kHz and through the closed loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import IdentificationError
from pipeline.identify.regression import Excitation
from pipeline.plant.plant import open_plant
from pipeline.plant.probing import InverseModel, probe
from pipeline.settings import ExcitationRun, ExcitationSettings
from pipeline.signals.frames import joint_columns
from pipeline.simulate.excitation import Objective, Task
from pipeline.simulate.excitation_search import Search
from pipeline.simulate.trajectory import Limits, Waypoints, peaks, reference_frame, sample
from pipeline.workflow.acquire import run_loop
from pipeline.workflow.batch import motion_excitation
from pipeline.workflow.building import build_fmus
from pipeline.workflow.engine import regressor_engine
from pipeline.workflow.excitation_settings import CHECK_RATE, check_friction, excitation_settings, run_settings
from pipeline.workflow.session import Session

Tell = Callable[[int, int, float], None]
"""Gets the iterations done, their number, and the best so far."""

QUANTITIES = ("q", "qd", "qdd", "tau")
MARGIN = 0.99  # of limits and caps: a squared hinge gives way a little
ROUNDS = 8
SLOW = 0.05  # of the limit of |qd|
OVERDO = 1.002  # by how much more than it was left a limit or a cap is shrunk
DECIMALS = 4  # of way-points: finer than any robot follows


@dataclass(frozen=True)
class Design:
    """A trajectory within its limits: how well it excites, and `used` (4, n), its share of q, qd, qdd, tau's limits.

    log_det: of the relative information at the data's rate; looped: whether the closed loop was checked, too.
    """

    waypoints: Waypoints
    log_det: float
    excitation: Excitation
    used: np.ndarray
    looped: bool
    interrupted: bool = False


def excite(session: Session, validation: bool = False, tell: Tell = lambda *_: None) -> Design:
    """Design the identification (or validation) trajectory; its seed is the experiment's.

    An interruption ends the search, and the best so far is finished. Raises ConfigError without an [excitation] table,
    IdentificationError where the limits and caps cannot be met, with what was reached.
    """
    settings = excitation_settings(session)
    run = run_settings(session.experiment.name, settings, validation)
    build_fmus(session)
    rng = np.random.default_rng([session.experiment.seed, int(validation)])
    search = Search(settings.starts, settings.iterations, session.narrate, tell)
    interrupted = False
    with _inverse_model(session, settings) as model:
        check_friction(session, settings, model)
        task = _task(session, settings, run, model)
        objective = Objective(model, task)

        def adapt(x: np.ndarray) -> Objective:
            plan, loop = _used(session, model, _waypoints(session, objective, x))
            return Objective(model, replace(task, margin=task.margin * np.minimum(1.0, plan / loop)))

        try:
            with session.stage("search"):
                search.run(objective, rng, adapt)
        except KeyboardInterrupt:
            if search.x is None:
                raise
            interrupted = True
            session.narrate("interrupted: finishing the best so far; once more to stop")
        with session.stage("checks"):
            return replace(_within(session, settings, model, search), interrupted=interrupted)


def entry(design: Design) -> dict:
    """A design's figures, as JSON takes them."""
    return {
        "log_det": design.log_det,
        "condition_number_W": design.excitation.condition_number_W,
        "condition_number_Phi": design.excitation.condition_number_Phi,
        "left_out_of_Phi": list(design.excitation.left_out_of_Phi),
        "used": dict(zip(QUANTITIES, design.used.tolist(), strict=True)),
        "closed_loop_checked": design.looped,
        "interrupted": design.interrupted,
    }


def _within(session: Session, settings: ExcitationSettings, model: InverseModel, search: Search) -> Design:
    """The best so far, polished and checked; where it leaves a limit or a cap, its own are shrunk, and it goes on."""
    search.polish(search.objective, 2)
    for _ in range(ROUNDS):
        task = search.objective.task
        design = _examine(session, model, task, _waypoints(session, search.objective, search.x))
        over_W, over_Phi = _over_caps(design.excitation, settings)
        if max(design.used.max(), over_W, over_Phi) <= 1.0:
            return design
        margin = task.margin / np.where(design.used > 1.0, design.used * OVERDO, 1.0)
        cap_W = task.cap_W / (over_W * OVERDO if over_W > 1.0 else 1.0)
        cap_Phi = task.cap_Phi / (over_Phi * OVERDO if over_Phi > 1.0 else 1.0)
        search.polish(Objective(model, replace(task, margin=margin, cap_W=cap_W, cap_Phi=cap_Phi)))
    raise IdentificationError(_refusal(session, settings, design))


def _over_caps(excitation: Excitation, settings: ExcitationSettings) -> tuple[float, float]:
    """Both condition numbers as a share of their caps, 0 where there is no cap."""
    pairs = (
        (excitation.condition_number_W, settings.condition_number_W),
        (excitation.condition_number_Phi, settings.condition_number_Phi),
    )
    return tuple(found / cap if found and cap else 0.0 for found, cap in pairs)


def _examine(session: Session, model: InverseModel, task: Task, waypoints: Waypoints) -> Design:
    """What a trajectory is worth, and how far it goes."""
    found = motion_excitation(model, sample(waypoints, task.rate), session.binding, task.sigma)
    log_det = 2.0 * float(np.log(found.singular_values).sum() + np.log(task.scale).sum())
    used = np.maximum(*_used(session, model, waypoints))
    return Design(waypoints, log_det, found, used, session.experiment.controller is not None)


def _used(session: Session, model: InverseModel, waypoints: Waypoints) -> tuple[np.ndarray, np.ndarray]:
    """The largest q, qd, qdd, tau (4, n) as shares of their limits: of the plan at 1 kHz, and of the closed loop."""
    settings, motion = session.experiment.excitation, sample(waypoints, CHECK_RATE)
    limits = np.array([getattr(settings, name) for name in QUANTITIES])
    plan = peaks(motion, model.torque(motion.q, motion.qd, motion.qdd, session.binding.a_priori))
    loop = plan.copy()
    if session.experiment.controller is not None:
        loop[[0, 1, 3]] = _loop_peaks(session, waypoints)
    return plan / limits, loop / limits


def _loop_peaks(session: Session, waypoints: Waypoints) -> np.ndarray:
    """The largest |q|, |qd|, |tau| (3, n) of the noise-free closed loop on a trajectory."""
    simulation, binding = session.experiment.simulation, session.binding
    chi = np.array([simulation.truth[name] for name in binding.names]) if simulation else binding.a_priori
    reference = reference_frame(sample(waypoints, 1.0 / session.experiment.controller.period))
    frame = run_loop(session, reference, chi)
    columns = [joint_columns(c, binding.n) for c in ("q_true", "qd_true", "tau_true")]
    return np.array([np.abs(frame[c].to_numpy()).max(axis=0) for c in columns])


@contextmanager
def _inverse_model(session: Session, settings: ExcitationSettings) -> Iterator[InverseModel]:
    """The probed inverse model, its structure tested at random points within the limits."""
    rng, binding = np.random.default_rng(session.experiment.seed), session.binding
    motion = [rng.uniform(-1.0, 1.0, (50, binding.n)) * getattr(settings, name) for name in QUANTITIES[:3]]
    with open_plant(binding, "probe", engine=regressor_engine(session, *motion)) as plant:
        yield probe(plant, *motion)


def _task(session: Session, settings: ExcitationSettings, run: ExcitationRun, model: InverseModel) -> Task:
    binding, experiment = session.binding, session.experiment
    chi = binding.select(binding.a_priori, model.names)
    return Task(
        t=run.segment * np.arange(run.segments + 1),
        limits=Limits(settings.q, settings.qd, settings.qdd, settings.tau),
        margin=np.full((4, binding.n), MARGIN),
        slow=np.array(settings.slow or [SLOW * limit for limit in settings.qd]),
        chi=chi,
        scale=np.where(chi == 0.0, binding.select(binding.scale, model.names), np.abs(chi)),
        sigma=_sigma_tau(session, settings),
        rate=(experiment.simulation or experiment.data).rate,
        grid=settings.grid,
        cap_W=MARGIN * (settings.condition_number_W or np.inf),
        cap_Phi=MARGIN * (settings.condition_number_Phi or np.inf),
        names=model.names,
    )


def _sigma_tau(session: Session, settings: ExcitationSettings) -> np.ndarray:
    """The torque's noise (n,): the setting, else that of the simulation where it is not 0, else 1."""
    simulation = session.experiment.simulation
    if settings.sigma_tau:
        return np.array(settings.sigma_tau)
    if simulation is not None and all(simulation.sigma_u):
        return np.array(simulation.sigma_u) * np.abs(session.binding.gain)
    return np.ones(session.binding.n)


def _waypoints(session: Session, objective: Objective, x: np.ndarray) -> Waypoints:
    """The way-points that x (m,) stands for, rounded as they are stored."""
    w = objective.waypoints(x, session.binding.joint[0].position_unit)
    return Waypoints(w.t, *(np.round(v, DECIMALS) + 0.0 for v in (w.q, w.qd, w.qdd)), w.unit)


def _refusal(session: Session, settings: ExcitationSettings, design: Design) -> str:
    """What was reached and does not do."""
    found = [
        f"{name} of joint {i + 1} {100 * design.used[row, i]:.1f} % of its limit"
        for row, name in enumerate(QUANTITIES)
        for i in np.flatnonzero(design.used[row] > 1.0)
    ]
    names = ("condition_number_W", "condition_number_Phi")
    for name, over in zip(names, _over_caps(design.excitation, settings), strict=True):
        if over > 1.0:
            found.append(f"{name} {getattr(design.excitation, name):.0f}, its cap is {getattr(settings, name):g}")
    return (
        f"{session.experiment.name}: no trajectory within [excitation] was found, the best reached {', '.join(found)}; "
        "widen that, or give more segments, starts or iterations"
    )
