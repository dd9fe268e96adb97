"""The design's objective: against numpy on the paper's closed form, its gradient against differences, its search."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import IdentificationError
from pipeline.simulate.excitation import Objective, Task, criterion, expand, hinge, positions_that_matter
from pipeline.simulate.excitation_search import FULL, Search
from pipeline.simulate.trajectory import Limits, sample
from tests.closed_form import TRUTH, Affine, regressor

SCALE = np.where(TRUTH == 0.0, 0.05, TRUTH)
SIGMA = np.array([1.0, 0.05])
TASK = Task(
    t=1.25 * np.arange(7),
    limits=Limits((2.4, 2.4), (2.6, 6.0), (4.5, 45.0), (16.0, 3.0)),
    margin=np.full((4, 2), 0.9),
    slow=np.array([0.13, 0.3]),
    chi=TRUTH,
    scale=SCALE,
    sigma=SIGMA,
    rate=100.0,
    grid=10.0,
)
BOUNDS = np.array([TASK.limits.q, TASK.limits.qd, TASK.limits.qdd, TASK.limits.tau])


def relative_log_det(motion):
    """The same by numpy alone, from the closed form and the whole determinant."""
    D = regressor(motion.q, motion.qd, motion.qdd)
    W = np.vstack([D[:, i] / SIGMA[i] for i in range(2)]) * SCALE
    return np.linalg.slogdet(W.T @ W)[1]


@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 1.4]))
@settings(max_examples=20, deadline=None)
def test_the_gradient_is_that_of_differences(seed, size):
    """Beyond limits and caps too: the larger motion leaves them all."""
    rng = np.random.default_rng(seed)
    objective = Objective(Affine(), replace(TASK, cap_W=100.0, cap_Phi=50.0))
    x = size * objective.start(rng)
    direction = rng.standard_normal(x.shape)
    step = 1e-7 * direction / np.linalg.norm(direction)
    expected = (objective(x + step, 100.0)[0] - objective(x - step, 100.0)[0]) / 2.0
    slope = objective(x, 100.0)[1]
    assert slope @ step == pytest.approx(expected, rel=1e-4, abs=1e-6 * np.linalg.norm(slope) * np.linalg.norm(step))


def test_the_criterion_is_the_log_determinant_and_its_derivative():
    rng = np.random.default_rng(0)
    q, qd, qdd = rng.uniform(-1.0, 1.0, (3, 200, 2)) * BOUNDS[:3, None]
    D, weight = regressor(q, qd, qdd), 1.0 / SIGMA**2
    value, by_D = criterion(D, weight, TASK, 1.0)
    W = (D / SIGMA[:, None]).reshape(-1, 8) * SCALE
    assert value == pytest.approx(-np.linalg.slogdet(W.T @ W)[1], rel=1e-12)
    capped = replace(TASK, cap_W=50.0, cap_Phi=30.0)
    value, by_D = criterion(D, weight, capped, 7.0)
    known = TRUTH != 0.0
    conds = np.linalg.cond(W / SCALE), np.linalg.cond((W / SCALE * TRUTH)[:, known])
    over = [np.log(c / cap) for c, cap in zip(conds, (50.0, 30.0), strict=True)]
    assert min(over) > 0.0
    assert value == pytest.approx(-np.linalg.slogdet(W.T @ W)[1] + 7.0 * np.sum(np.square(over)), rel=1e-12)
    change = 1e-6 * rng.standard_normal(D.shape)
    ahead, behind = (criterion(D + sign * change, weight, capped, 7.0)[0] for sign in (1.0, -1.0))
    assert np.sum(by_D * change) == pytest.approx((ahead - behind) / 2.0, rel=1e-6)


def test_a_parameter_that_nothing_excites_is_refused():
    D = regressor(*np.random.default_rng(0).normal(size=(3, 50, 2)))
    D[..., 4] = 0.0
    with pytest.raises(IdentificationError, match=r"parameter 5 is not excited .*share is 0, .*tau = 16, 3.*segments"):
        criterion(D, np.ones(2), TASK, 1.0)
    with pytest.raises(IdentificationError, match=r"excitation: E is not excited"):
        criterion(D, np.ones(2), replace(TASK, names=tuple("ABCDEFGH")), 1.0)


def test_the_objective_is_the_whole_records_log_determinant():
    """On the samples' own grid, and with sgn(qd) all but sharp: half a sample's shift is all that parts them."""
    objective = Objective(Affine(), replace(TASK, grid=100.0, slow=np.full(2, 1e-4)))
    for seed in range(5):
        x = 0.8 * objective.start(np.random.default_rng(seed))
        motion = sample(objective.waypoints(x), 100.0)
        assert -objective(x, 0.0)[0] == pytest.approx(relative_log_det(motion), abs=0.1)


def test_the_regressor_is_exact_at_the_knots_and_its_parts_are():
    rng = np.random.default_rng(1)
    step, cell = 1e-6 * BOUNDS[0], 0.05 * BOUNDS[1]
    q, qdd = rng.uniform(-1.0, 1.0, (2, 100, 2)) * BOUNDS[[0, 2], None]
    qd = (rng.integers(-10, 10, (100, 2)) + 0.5) * cell
    found = expand(Affine(), q, qd, qdd, step, cell, [0, 1])
    np.testing.assert_allclose(found.D[..., :8], regressor(q, qd, qdd), atol=1e-11)
    shift = 1e-5 * np.array([0.0, 1.0])
    expected = (regressor(q + shift, qd, qdd) - regressor(q - shift, qd, qdd)) / 2e-5
    np.testing.assert_allclose(found.by_q[..., :8, 1], expected, atol=1e-3)


def test_a_joint_whose_position_says_nothing_is_left_out():
    assert positions_that_matter(Affine(), BOUNDS) == [1]


def test_a_start_keeps_the_limits_and_rests_at_both_ends():
    objective = Objective(Affine(), TASK)
    waypoints = objective.waypoints(objective.start(np.random.default_rng(3)), "rad")
    motion = sample(waypoints, 1000.0)
    reached = [np.abs(x).max(axis=0) for x in (motion.q, motion.qd, motion.qdd)]
    assert np.all(reached / BOUNDS[:3] <= 0.905) and np.max(reached / BOUNDS[:3]) > 0.89
    assert not waypoints.q[0].any()
    for rest in (waypoints.qd[[0, -1]], waypoints.qdd[[0, -1]]):
        assert not rest.any()


def test_hinge():
    value, slope = hinge(np.array([[0.5, -4.0], [-3.0, 1.0]]), np.array([1.0, 2.0]))
    assert value == pytest.approx(1.0 + 4.0)
    np.testing.assert_allclose(slope, [[0.0, -1.0], [-4.0, 0.0]])


def searched(tell=lambda *_: None):
    objective = Objective(Affine(), TASK)
    search = Search(2, 10, tell=tell)
    search.run(objective, np.random.default_rng(5), lambda x: objective)
    search.polish(search.objective)
    return objective, search


def test_the_same_seed_gives_the_same_bits_and_better_than_the_start():
    (objective, one), (_, two) = searched(), searched()
    np.testing.assert_array_equal(one.x, two.x)
    starts = [objective(objective.start(r), FULL)[0] for r in np.random.default_rng(5).spawn(2)]
    assert one.value < min(starts) - 3.0


def test_an_interruption_leaves_the_best_so_far():
    told = []

    def tell(done, total, best):
        told.append((done, total, best))
        if done == 25:
            raise KeyboardInterrupt

    objective = Objective(Affine(), TASK)
    search = Search(2, 10, tell=tell)
    with pytest.raises(KeyboardInterrupt):
        search.run(objective, np.random.default_rng(5), lambda x: objective)
    assert told[-1][:2] == (25, 60) and told[-1][2] == -search.value
    assert objective(search.x, FULL)[0] == pytest.approx(search.value)
