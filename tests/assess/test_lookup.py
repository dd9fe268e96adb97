"""Looking things up in a run record."""

import pytest

from pipeline.assess.lookup import (
    apart,
    errors_in_sigma,
    percent_off,
    prediction_errors,
    recommended,
    rk4_partner,
    usable,
)


def estimate(sigma=0.1, method="WLS", status="ok", **values):
    parameters = {p: {"value": v, "sigma": sigma, "truth": 1.0, "a_priori": 1.0} for p, v in values.items()}
    return {"status": status, "method": method, "parameters": parameters}


def test_recommended_is_the_experiments_then_the_essential_then_the_last():
    record = {"estimates": {"A": estimate(a=1.0), "B": estimate(a=1.0), "EKF": estimate(method="EKF", a=1.0)}}
    assert recommended(record) == "B"
    record["estimates"]["A"]["essential"] = {"kept": ["a"]}
    assert recommended(record) == "A"
    record["experiment"] = {"configuration": {"recommended": "B"}}
    assert recommended(record) == "B"
    record["estimates"]["B"]["status"] = "failed"
    assert recommended(record) == "A"
    assert recommended({}) is None


def test_apart_in_combined_sigma():
    gap = apart(estimate(0.3, a=1.0, b=2.0), estimate(0.4, a=1.5, b=2.1))
    assert gap.parameter == "a" and gap.distance == pytest.approx(1.0) and gap.in_sigma and gap.close
    assert str(gap) == "1.0 sigma"
    assert apart(estimate(None, a=1.0), estimate(0.1, a=1.5)).distance == pytest.approx(5.0)


def test_apart_in_percent_where_no_sigma_is_known():
    gap = apart(estimate(None, a=1.01, b=2.1), estimate(None, a=1.0, b=2.0))
    assert (gap.parameter, str(gap), gap.in_sigma, gap.close) == ("b", "5.0 %", False, False)
    assert apart(estimate(a=1.0), estimate(b=1.0)) is None


def test_errors_and_percents():
    assert errors_in_sigma(estimate(0.1, a=1.3)) == {"a": pytest.approx(3.0)}
    assert errors_in_sigma(estimate(None, a=1.3)) == {}
    assert percent_off(estimate(a=-3.3, b=1.0), {"a": {"value": -3.0}, "c": {"value": 1.0}}) == {
        "a": pytest.approx(-10.0)
    }


def test_prediction_errors_are_those_of_the_living():
    record = {"estimates": {"A": estimate(a=1.0), "B": estimate(status="failed", a=1.0)}}
    record["validation"] = {"validation": {"A": {"total": 4.0}, "B": {"total": 1.0}, "C": {"total": 2.0}}}
    assert prediction_errors(record) == {"A": 4.0}
    assert list(usable(record)) == ["A"]


def test_the_partner_of_an_euler_run_has_its_start_and_tuning():
    estimates = {}
    for name, tuning in (("EKF(3)", "paper"), ("EKF(2) known", "known"), ("EKF(3) known", "known")):
        estimates[name] = {**estimate(method="EKF", a=1.0), "tuning": tuning, "settings": {"transition": "RK4"}}
    estimates["EKF(3) Euler"] = {**estimates["EKF(3) known"], "settings": {"transition": "Euler (Eq. 13)"}}
    assert rk4_partner({"estimates": estimates}, "EKF(3) Euler") == "EKF(3) known"
    assert rk4_partner({"estimates": estimates}, "EKF(3)") is None
