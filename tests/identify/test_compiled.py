"""The compiled filter: the bits of Python's, and the same word on whatever goes wrong, at the same sample."""

import numpy as np
import pytest
from msgspec import structs

from pipeline.identify.ekf import Tuning, run_filter
from pipeline.plant.binding import load_binding
from pipeline.plant.plant import open_plant
from tests.plant.moody import CHATTER, NAN, TERMINATE, build_moody, moody_binding

pytestmark = pytest.mark.usefixtures("temporary_folders")

DT, SAMPLES = 0.01, 40
TRANSITIONS = [("ME", "euler", 1), ("ME", "rk4", 1), ("ME", "rk4", 4), ("CS", "rk4", 1), ("CS reset", "rk4", 1)]
PLANTS = ["scara", "scara_fmi3", "scara_inputs", "scara_inputs_fmi3", "emps", "emps_inputs_fmi3"]
MODES = [("forward", "udu"), ("central", "joseph"), ("directional", "udu"), ("directional", "joseph")]


def record(binding, samples=SAMPLES, seed=1):
    """Some motion that the filter can follow for a while: time, q, u, z0, P0, tuning."""
    rng, n = np.random.default_rng(seed), binding.n
    time = DT * np.arange(samples)
    q = 0.3 * np.sin(3 * time[:, None] + np.arange(n)) + 1e-3 * rng.normal(size=(samples, n))
    u = binding.u_range * 0.3 * rng.normal(size=(samples, n))
    chi = binding.a_priori + 0.05 * binding.scale
    z0 = np.concatenate([np.zeros(n), q[0], chi])
    P0 = np.diag(np.concatenate([np.full(n, 1e-1), np.full(n, 1e-4), (0.1 * binding.scale) ** 2]))
    input_noise = bool(seed % 2)
    noise = np.full(n, 0.1) if input_noise else np.full(2 * n, 1e-4)
    return time, q, u, z0, P0, Tuning(np.full(n, 1e-6), noise, input_noise)


def both(binding, transition, *arguments, mode=("forward", "udu")):
    """The runs of both engines."""
    runs = []
    for engine in ("python", "compiled"):
        with open_plant(binding, "filter", *transition, engine) as plant:
            runs.append((run_filter(plant, *arguments, *mode), plant.calls))
    return runs


def assert_same(runs):
    (python, calls), (compiled, compiled_calls) = runs
    assert (compiled.failed_at, compiled_calls) == (python.failed_at, calls)
    for name in ("time", "x", "P_diag", "innovation", "S_diag", "NIS", "P"):
        np.testing.assert_array_equal(getattr(compiled, name), getattr(python, name), err_msg=name)


@pytest.mark.parametrize("transition", TRANSITIONS, ids=lambda t: " ".join(map(str, t)))
@pytest.mark.parametrize("name", PLANTS)
def test_both_engines_give_the_same_bits(fmus, name, transition):
    binding = load_binding(str(fmus / f"{name.removesuffix('_fmi3')}.toml"))
    binding = structs.replace(binding, fmu=f"{name}.fmu")
    for seed, mode in enumerate(MODES):
        if mode[0] == "directional" and transition[0] != "ME":
            continue
        runs = both(binding, transition, *record(binding, seed=seed), mode=mode)
        assert runs[0][0].failed_at is None and len(runs[0][0].x) == SAMPLES
        assert_same(runs)


def test_filterpy_is_of_the_same_opinion(fmus):
    """With exact derivatives by everything; the round-off of differences would part the two by 1e-5 sigma."""
    binding = load_binding(str(fmus / "scara_inputs.toml"))
    arguments = record(binding)
    with open_plant(binding, "filter", *TRANSITIONS[2]) as plant:
        opinion = run_filter(plant, *arguments, "directional", "filterpy")
    for covariance in ("udu", "joseph"):
        _, (ours, _) = both(binding, TRANSITIONS[2], *arguments, mode=("directional", covariance))
        assert np.max(np.abs(ours.x - opinion.x) / np.sqrt(opinion.P_diag)) < 1e-9
        np.testing.assert_allclose(ours.P_diag, opinion.P_diag, rtol=1e-9)
        np.testing.assert_allclose(ours.NIS, opinion.NIS, rtol=1e-8, atol=1e-9)


@pytest.fixture(scope="module")
def moody(tmp_path_factory):
    return build_moody(tmp_path_factory.mktemp("moody"))


SINCE = 0.145
MOODY_ME = [
    (
        "SetContinuousStates",
        1,
        "fmi2SetContinuousStates at t = 0.15 s returned Warning (fmi2SetContinuousStates is in a",
    ),
    ("GetDerivatives", 2, "fmi2GetDerivatives at t = 0.15 s returned Discard"),
    ("GetDerivatives", 3, "fmi2GetDerivatives at t = 0.15 s returned Error"),
    ("GetDerivatives", 4, "fmi2GetDerivatives at t = 0.15 s returned Fatal"),
    ("GetDerivatives", 77, "fmi2GetDerivatives at t = 0.15 s returned an illegal status 77"),
    ("GetDerivatives", NAN, "fmi2GetDerivatives at t = 0.15 s gave a value that is not finite"),
    ("SetTime", 3, "fmi2SetTime at t = 0.15 s returned Error"),
    ("SetReal", 3, "setting the parameters at t = 0.15 s returned Error"),
    ("EnterEventMode", 3, "fmi2EnterEventMode at t = 0.15 s returned Error"),
    ("NewDiscreteStates", 2, "the event iteration at t = 0.15 s returned Discard"),
    ("NewDiscreteStates", TERMINATE, "the event iteration at t = 0.15 s asked to terminate"),
    ("NewDiscreteStates", CHATTER, "the event iteration at t = 0.15 s did not end after 100 iterations"),
    ("EnterContinuousTimeMode", 3, "fmi2EnterContinuousTimeMode at t = 0.15 s returned Error"),
    ("CompletedIntegratorStep", 1, "fmi2CompletedIntegratorStep at t = 0.15 s returned Warning"),
    ("CompletedIntegratorStep", TERMINATE, "fmi2CompletedIntegratorStep at t = 0.15 s asked to terminate"),
]
MOODY_CS = [
    ("ExitInitializationMode", 3, "fmi2ExitInitializationMode at t = 0.15 s returned Error"),
    ("DoStep", 2, "fmi2DoStep at t = 0.15 s returned Discard"),
    ("DoStep", 4, "fmi2DoStep at t = 0.15 s returned Fatal"),
    ("DoStep", NAN, "fmi2DoStep at t = 0.15 s gave a value that is not finite"),
]
MOODY = [
    *((TRANSITIONS[2], *case) for case in MOODY_ME),
    *((TRANSITIONS[3], *case) for case in MOODY_CS),
    *((TRANSITIONS[4], *case) for case in MOODY_CS),
]


@pytest.mark.parametrize(
    ("transition", "mood", "outcome", "reason"), MOODY, ids=lambda v: str(v).replace(" ", "-")[:40]
)
def test_a_failing_call_stops_at_its_sample_and_keeps_what_was_before(moody, transition, mood, outcome, reason):
    arguments = record(moody_binding(moody))
    runs = both(moody_binding(moody, mood, outcome, SINCE), transition, *arguments)
    whole = both(moody_binding(moody), transition, *arguments)[1][0]
    assert_same(runs)
    (python, _), (compiled, _) = runs
    assert compiled.failed_at == 16 and reason in compiled.reason
    assert compiled.reason == python.reason
    np.testing.assert_array_equal(compiled.x, whole.x[:16])


@pytest.mark.parametrize("transition", [TRANSITIONS[2], TRANSITIONS[3]], ids=["ME", "CS"])
def test_a_flood_of_messages_is_capped(moody, transition):
    mood = "GetDerivatives" if transition[0] == "ME" else "DoStep"
    binding = moody_binding(moody, mood, 3, SINCE, flood=5000)
    with open_plant(binding, "filter", *transition, "compiled") as plant:
        run = run_filter(plant, *record(binding))
        assert len(plant.instance.log) <= 20
    assert run.failed_at == 16 and "is in a mood" in run.reason and "\n" not in run.reason


def test_what_makes_no_filter_is_said_at_its_sample(moody):
    time, q, u, z0, P0, tuning = record(moody_binding(moody))
    no_mass = np.concatenate([z0[:2], [-2.0, 3.0]])
    lost = q.copy()
    lost[25] = np.nan
    indefinite = P0.copy()
    indefinite[0, 1] = indefinite[1, 0] = 10.0
    for arguments, sample, reason in (
        ((time, q, u, no_mass, P0, tuning), 1, "mass matrix lost positive definiteness"),
        ((time, lost, u, z0, P0, tuning), 25, "not finite"),
        ((time, q, u, z0, indefinite, tuning), 0, "not positive semi-definite"),
    ):
        runs = both(moody_binding(moody), TRANSITIONS[2], *arguments)
        assert_same(runs)
        assert (runs[1][0].failed_at, runs[0][0].reason) == (sample, runs[1][0].reason)
        assert reason in runs[1][0].reason


def test_joseph_says_where_P_is_lost(moody):
    time, q, u, z0, P0, _ = record(moody_binding(moody))
    tuning = Tuning(np.array([1e-300]), np.array([1e-12]), True)
    runs = both(moody_binding(moody), TRANSITIONS[2], time, q, u, z0, 1e16 * P0, tuning, mode=("forward", "joseph"))
    assert_same(runs)
    assert runs[1][0].failed_at is not None and "positive definiteness" in runs[1][0].reason
