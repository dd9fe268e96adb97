"""The loop stage: bandwidth and margins of the closed loop of both FMUs, and the filters that follow from them."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from msgspec import structs

from pipeline.errors import ConfigError, FmuidError
from pipeline.plant.fmu import open_fmu
from pipeline.plant.linearisation import LinearPlant, answers_alike, linear_plant, pulse_responses
from pipeline.plant.plant import open_plant
from pipeline.signals.cutoffs import described, follows_loop, resolve
from pipeline.signals.frames import joint_columns
from pipeline.workflow.session import Session

CONFIGURATIONS = 9


@dataclass(frozen=True)
class LoopStage:
    """The loop at each configuration (plants and responses side by side), f_dyn in Hz, and each variant's numbers.

    f_dyn is the largest bandwidth of a joint, in the middle (the median) of the configurations: the extreme poses are
    some that the motion hardly visits. Where there is no loop to analyse, `reason` says why and f_dyn is None. filters:
    by WLS variant the value and the source of both cut-offs and of the decimation.
    """

    plants: tuple[LinearPlant, ...]
    responses: tuple
    f_dyn: float | None
    filters: dict[str, dict]
    reason: str = ""


def follow_loop(session: Session, frame: pd.DataFrame) -> tuple[Session, LoopStage]:
    """The session with every filter's numbers in place, and the loop they follow.

    Raises the loop's error where it cannot be analysed and a filter needs it; else the error becomes the reason.
    """
    variants = session.experiment.wls
    plants, responses, f_dyn, reason = (), (), None, ""
    try:
        plants, responses = analyse_loop(session, frame)
        f_dyn = float(np.median([r.bandwidth.max() for r in responses]))
    except FmuidError as error:
        reason = str(error)
        needy = [w.name for w in variants if follows_loop(w)]
        if needy:
            what = f"{needy[0]}: its cut-offs follow the closed loop, which cannot be analysed"
            raise type(error)(f"{what}: {error} (or set the cut-offs)") from error
    resolved = tuple(resolve(w, session.rate, f_dyn) for w in variants)
    filters = {w.name: described(w, r, session.rate) for w, r in zip(variants, resolved, strict=True)}
    session = replace(session, experiment=structs.replace(session.experiment, wls=resolved))
    return session, LoopStage(plants, responses, f_dyn, filters, reason)


def analyse_loop(session: Session, frame: pd.DataFrame) -> tuple[tuple[LinearPlant, ...], tuple]:
    """The linear plants at rest at positions spread over the motion, and the loop's response at each."""
    controller, binding = session.experiment.controller, session.binding
    if controller is None:
        raise ConfigError("the experiment has no [controller], so no loop to analyse")
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # comes along; nobody here needs to know where it caches
    from pipeline.signals.bandwidth import analyse, realise, sampled_plant  # python-control: 0.3 s

    positions = spread(motion(frame, binding.n), CONFIGURATIONS)
    with open_plant(binding, "linearise") as plant:
        plants = tuple(linear_plant(plant, q) for q in positions)
    with open_fmu(session.controller_fmu) as file:
        markov = [pulse_responses(file, controller, positions[0], binding.u_range)]
        for q in positions[1:]:
            same = answers_alike(file, controller, q, binding.u_range, markov[0])
            markov.append(markov[0] if same else pulse_responses(file, controller, q, binding.u_range))
    period = controller.period
    responses = tuple(
        analyse(sampled_plant(p.A, p.B, period), realise(H, period)) for p, H in zip(plants, markov, strict=True)
    )
    return plants, responses


def motion(frame: pd.DataFrame, n: int) -> np.ndarray:
    """The positions (N, n) a record goes through: its reference, which is free of noise, or else what was measured."""
    known = set(joint_columns("qr", n)) <= set(frame)
    return frame[joint_columns("qr" if known else "q", n)].to_numpy(float)


def spread(q: np.ndarray, count: int) -> np.ndarray:
    """`count` rows of a motion q (N, n) spread over it: the middle, then always the one farthest from all others."""
    span = np.ptp(q, axis=0)
    scaled = q / np.where(span > 0.0, span, 1.0)
    chosen = [int(np.argmin(np.linalg.norm(scaled - np.median(scaled, axis=0), axis=1)))]
    distance = np.full(len(q), np.inf)
    while len(chosen) < min(count, len(q)):
        distance = np.minimum(distance, np.linalg.norm(scaled - scaled[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(distance)))
    return q[chosen]
