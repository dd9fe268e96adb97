"""The harness of `make bench`: turns, medians, results.json, exit codes; and REF against the plain Python filter."""

import json
from itertools import count

import numpy as np
import pytest

from pipeline.errors import ConfigError
from pipeline.export.build import build
from pipeline.paths import FMUS
from pipeline.plant.plant import open_plant
from tests.benchmarks.__main__ import main
from tests.benchmarks.chain import chain_binding
from tests.benchmarks.chains import simulated
from tests.benchmarks.figure import at_least, at_most, information
from tests.benchmarks.filters import AGREED, apart, ekf, open_scara
from tests.benchmarks.record import scara
from tests.benchmarks.reference import reference
from tests.benchmarks.turns import Spread, in_turn, ratio, spread


def test_jobs_run_in_turn_after_a_warm_up_of_each():
    ran, clock = [], count()
    times = in_turn({"a": lambda: ran.append("a"), "b": lambda: ran.append("b")}, 3, lambda: float(next(clock)))
    assert "".join(ran) == "abababab"
    assert {name: t.tolist() for name, t in times.items()} == {"a": [1.0] * 3, "b": [1.0] * 3}


def test_a_ratio_is_the_median_over_the_rounds_of_each_rounds_ratio():
    times = {"a": np.array([1.0, 2.0, 30.0]), "b": np.array([1.0, 4.0, 10.0])}
    assert ratio(times, "a", "b") == Spread(1.0, 0.5, 3.0)
    assert spread(np.array([3.0, 1.0, 2.0])) == Spread(2.0, 1.0, 3.0)


@pytest.mark.parametrize(
    ("figure", "held"),
    [
        (at_most("", 1.0, "", 1.0), True),
        (at_most("", Spread(1.1, 0.9, 1.2), "", 1.0), False),
        (at_most("", float("nan"), "", 1.0), False),
        (at_least("", 1.0, "", 1.0), True),
        (at_least("", 0.9, "", 1.0), False),
        (information("", 7.0, ""), True),
    ],
)
def test_a_figure_holds_by_its_median(figure, held):
    assert figure.held is held


def test_results_and_exit_code(tmp_path, capsys):
    sections = {
        "good": lambda: [at_most("fast", Spread(0.5, 0.4, 0.6), "REF", 0.9)],
        "bad": lambda: [at_least("slow", 2.0, "REF", 3.0)],
    }
    results = tmp_path / "results.json"
    assert main(["good"], sections, results) == 0
    assert main([], sections, results) == 1
    out = capsys.readouterr().out
    assert "held   fast" in out and "MISSED slow" in out and "1 missed" in out
    found = json.loads(results.read_text())
    assert found["figures"][0] == {
        "name": "fast",
        "value": 0.5,
        "low": 0.4,
        "high": 0.6,
        "unit": "REF",
        "asked": "≤",
        "bound": 0.9,
        "held": True,
    }
    assert [f["held"] for f in found["figures"]] == [True, False]
    assert {"cpu", "compiler", "python", "numpy", "load", "commit"} <= set(found["environment"])


def test_a_section_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="no section nothing; there are good"):
        main(["nothing"], {"good": list}, tmp_path / "results.json")


@pytest.mark.parametrize("mode", AGREED)
def test_REF_agrees_with_the_plain_filter(fmus, mode):
    record = scara().first(300)
    with reference("scara") as ref, open_scara(engine="python") as plant:
        assert apart(ref(record, mode).x, ekf(plant, record, mode, "udu").x, record) <= AGREED[mode]


@pytest.mark.parametrize("mode", AGREED)
def test_REF_of_a_chain_agrees_with_the_plain_filter(mode):
    build(["chain2"], FMUS)
    binding = chain_binding(2, FMUS / "chain2.fmu")
    with reference("chain", LINKS=2) as ref, open_plant(binding, "filter", "ME", "euler") as plant:
        record = simulated(binding, plant).first(100)
        assert apart(ref(record, mode).x, ekf(plant, record, mode, "udu").x, record) <= AGREED[mode]
