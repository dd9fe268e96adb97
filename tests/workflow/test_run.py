"""A whole experiment on a short record: the record it leaves, and what it leaves when a stage fails."""

import json

import numpy as np
import pandas as pd
import pytest

from pipeline.errors import DataError
from pipeline.paths import EXPERIMENTS
from pipeline.report.record import read_run
from pipeline.workflow.acquire import acquire, simulate
from pipeline.workflow.run import _free, identify, run
from pipeline.workflow.session import open_session

QUICK = ["ekf.case.EKF(2).tunings=['paper']", "ekf.substeps=1", "ekf.method='euler'"]


@pytest.fixture(scope="module")
def scara(fmus, tmp_path_factory):
    """One run of the experiment by Euler, which is quick: folder, record, signals."""
    session = open_session("scara", QUICK)
    folder, record = run(session, str(tmp_path_factory.mktemp("reports") / "scara"))
    return folder, record, read_run(folder)[1]


def test_the_record_holds_what_the_schema_promises(scara):
    folder, record, signals = scara
    stored = json.loads((folder / "result.json").read_text())
    assert stored["schema"] == 1 and stored["run_id"] == "scara"
    assert (folder / "index.html").stat().st_size > 1e5
    assert list(stored["estimates"]) == [
        "WLS(1)", "WLS(2)", "WLS(3)", "RLS",
        "EKF(1)", "EKF(1) known", "EKF(1) derived", "EKF(2)",
        "EKF(3)", "EKF(3) known", "EKF(3) derived", "EKF(3) Euler",
    ]  # fmt: skip
    for estimate in stored["estimates"].values():
        assert set(estimate["parameters"]) == {"ZZR1", "Fv1", "Fs1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2"}
        assert estimate["signals"].removesuffix(".parquet") in signals
    assert stored["provenance"]["seed"] == 1 and set(stored["provenance"]["fmus"]) == {"scara", "scara_controller"}
    assert set(stored["timing"]["stages"]) == {"data", "loop", "WLS and RLS", "EKF", "validation"}
    assert stored["errors"] == [] and stored["findings"]


def test_ekf_1_is_a_failure_with_its_reason_and_never_a_number(scara):
    for tuning in ("EKF(1)", "EKF(1) known", "EKF(1) derived"):
        found = scara[1]["estimates"][tuning]
        assert found["status"] == "failed"
        assert "sample 1 (t = 0.01 s)" in found["reason"] and "no mass" in found["reason"]
        assert all(p["value"] is None and p["sigma"] is None for p in found["parameters"].values())


def test_sigma_is_withheld_exactly_where_a_reason_stands(scara):
    for found in scara[1]["estimates"].values():
        withheld = bool(found["sigma_reason"]) or found["status"] != "ok"
        assert all((p["sigma"] is None) == withheld for p in found["parameters"].values())


def test_rls_ends_where_wls_does(scara):
    rls, wls = (scara[1]["estimates"][name]["parameters"] for name in ("RLS", "WLS(3)"))
    for name, p in wls.items():
        assert abs(rls[name]["value"] - p["value"]) < 1e-9 * p["sigma"]


def test_signals_of_a_filter_are_complete(scara):
    table = scara[2]["ekf-3-known"]
    assert len(table) == 2501 and table.index.name == "time"
    for column in ("q_1", "qd_2", "sigma q_1", "innovation_2", "S_1", "NIS", "theta ZZR1", "sigma Fs2"):
        assert np.isfinite(table[column]).all()


def test_a_failed_stage_still_leaves_a_page(fmus, tmp_path):
    session = open_session("scara", ["wls.WLS(3).parallel.cutoff=0.001", "wls.WLS(3).decimation=10"])
    folder, record = run(session, str(tmp_path / "broken"))
    assert record["verdict"]["status"] == "fail"
    assert record["errors"][0]["stage"] == "WLS and RLS" and "not identifiable apart" in record["errors"][0]["message"]
    assert "not identifiable apart" in (folder / "index.html").read_text()


def test_a_recommended_filter_that_fails_is_a_failed_check_not_a_crash(fmus):
    record, _ = identify(open_session("scara", ["ekf.recommended='EKF(1)'", *QUICK]))
    assert record["verdict"]["status"] == "fail" and not record["errors"]
    assert {"name": "EKF(1) succeeded", "value": False, "limit": True, "status": "fail"} in record["verdict"]["items"]


def test_a_run_never_replaces_what_is_no_run(fmus, tmp_path):
    (tmp_path / "thesis.txt").write_text("three years of work")
    with pytest.raises(DataError, match="something that is no run stands there"):
        run(open_session("scara", QUICK), str(tmp_path))
    with pytest.raises(DataError, match="something that is no run stands there"):
        run(open_session("scara", QUICK), str(tmp_path / "thesis.txt"))
    assert (tmp_path / "thesis.txt").read_text() == "three years of work"


def test_two_runs_of_one_second_have_folders_of_their_own(tmp_path):
    (tmp_path / "scara-1").mkdir()
    (tmp_path / "scara-1-2").mkdir()
    assert _free(tmp_path / "scara-1").name == "scara-1-3"


def test_the_seed_alone_decides_the_noise(fmus):
    frames = [acquire(open_session("scara", [f"seed={seed}"])) for seed in (1, 1, 2)]
    assert frames[0].equals(frames[1])
    assert not frames[0]["q_1"].equals(frames[2]["q_1"])


def test_without_noise_what_is_measured_is_true(fmus):
    frame = simulate(open_session("scara"), noisy=False)
    np.testing.assert_array_equal(frame["q_1"], frame["q_true_1"])
    np.testing.assert_array_equal(frame["tau_2"], frame["tau_true_2"])


def test_an_estimate_is_named_after_its_tuning_where_there_is_a_choice():
    cases = {c.name: c for c in open_session("emps").experiment.ekf.case}
    assert cases["EKF(half)"].called("derived") == "EKF(half)"
    two = [c for c in open_session("scara").experiment.ekf.case if c.name == "EKF(3)"][1]
    assert [two.called(t) for t in two.tunings] == ["EKF(3) known", "EKF(3) derived"]


def test_missing_data_say_where_to_get_them(tmp_path):
    session = open_session("emps", data=str(tmp_path))
    with pytest.raises(
        DataError, match=r"DATA_EMPS\.mat: no such data file in .*; get it from the EMPS benchmark.*--data"
    ):
        acquire(session)


def test_the_measured_drive_gives_the_published_result(fmus, emps_data):
    session = open_session("emps", ["ekf.case=[]"], data=str(emps_data))
    record, signals = identify(session)
    published = record["reference"]["tables"][0]["estimates"]["Published"]["parameters"]
    for name, p in record["estimates"]["WLS(published)"]["parameters"].items():
        assert abs(p["value"] / published[name]["value"] - 1) < (0.006 if name == "offset" else 0.003)
        assert p["sigma"] is None, "the residual is coloured: its sigma must not be shown"
    own = record["validation"]["own_filters"]
    assert abs(own["WLS(published)"]["identification"] - 4.13) < 0.03
    assert abs(own["WLS(published)"]["validation"] - 6.00) < 0.03
    assert own["WLS(house)"]["validation"] < 4.7
    loop = record["validation"]["closed_loop"]
    for name, limits in {"identification": (0.0015, 0.15, 4.8), "validation": (0.002, 0.20, 5.5)}.items():
        for signal, limit in zip(("position", "velocity", "force"), limits, strict=True):
            assert loop[name][signal] < limit
    assert "closed_loop_validation" in signals


def test_a_robot_at_standstill_is_no_pass(fmus, tmp_path):
    """Nothing but noise: WLS solves, and what it finds is worth nothing."""
    rng = np.random.default_rng(0)
    time = np.arange(2501) / 100.0
    for name in ("one.csv", "two.csv"):
        noise = {f"{c}_{i}": s * rng.normal(size=len(time)) for i in (1, 2) for c, s in (("q", 1e-3), ("u", 0.05))}
        pd.DataFrame({"t": time, **noise}).to_csv(tmp_path / name, index=False)
    columns = {c: {"source": c, "unit": "rad" if c[0] == "q" else "N.m"} for c in ("q_1", "q_2", "u_1", "u_2")}
    text = (EXPERIMENTS / "scara.toml").read_text()
    lines = ["[data]", 'identification = "one.csv"', 'validation = "two.csv"', "rate = 100.0", "[data.columns]"]
    lines += ['time = { source = "t", unit = "s" }']
    lines += [f'{c} = {{ source = "{v["source"]}", unit = "{v["unit"]}" }}' for c, v in columns.items()]
    (tmp_path / "still.toml").write_text(text + "\n" + "\n".join(lines) + "\n")
    record, _ = identify(open_session(str(tmp_path / "still.toml"), ["ekf.case=[]"]))
    assert record["verdict"]["status"] == "fail"


def test_a_force_of_the_wrong_sign_is_no_pass(fmus, emps_data):
    session = open_session("emps", ["data.columns.u_1.scale=-1.0", "ekf.case=[]", "limits={}"], data=str(emps_data))
    record, _ = identify(session)
    items = {item["name"]: item["status"] for item in record["verdict"]["items"]}
    assert items["WLS(house) mass matrix positive all along the motion"] == "fail"
