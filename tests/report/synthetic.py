"""Complete, plausible run records with signals, made without a simulation, for the tests of the report."""

import numpy as np
import pandas as pd

from pipeline.config import slug

UNITS = {
    "ZZR1": "kg.m2",
    "Fv1": "N.m.s/rad",
    "Fs1": "N.m",
    "ZZ2": "kg.m2",
    "LMX2": "kg.m2",
    "LMY2": "kg.m2",
    "Fv2": "N.m.s/rad",
    "Fs2": "N.m",
}
TRUTH = [3.42, 0.07, 0.58, 0.064, 0.131, 0.0, 0.015, 0.156]
SIGMA = [0.0084, 0.026, 0.031, 0.00024, 0.0005, 0.00046, 0.001, 0.0022]
PAPER = {
    "WLS(1)": ([0.51, -0.66, 0.81, 0.056, 0.042, 0.002, 0.021, 0.13], [4.8, 24, 9.4, 0.73, 4, 65, 6, 2.5]),
    "WLS(2)": ([3.26, -0.2, 0.55, 0.064, 0.13, 0.004, -0.006, 0.17], [1.2, 60, 9.6, 0.8, 1.7, 60, 22, 2.3]),
    "WLS(3)": ([3.47, 0.3, 0.4, 0.063, 0.125, 0.003, 0.014, 0.13], [0.8, 25, 9, 0.45, 1.2, 49, 6, 1.7]),
    "EKF(2)": (
        [3.21, -0.95, 1.28, 0.06, 0.123, 0.064, 0.0159, 0.127],
        [0.17, -1.67, 0.53, 0.14, 0.49, 0.69, 1.57, 0.64],
    ),
    "EKF(3)": ([3.31, 0.6, 0.58, 0.061, 0.14, 0.03, 0.012, 0.13], [0.2, 3.6, 1.4, 0.11, 0.39, 1.05, 1.12, 0.34]),
}
SINGULAR = "the inertia matrix is singular at sample 0 (all parameters 0): start from values with M > 0"
COLOURED = "mean NIS 0.005 is below its band 1.82 … 2.18: R and Q are far larger than the noise"


def scara(samples=2500):
    """(record, signals) like the simulated SCARA's: 2 joints, 8 parameters, failed and withheld ones included."""
    rng = np.random.default_rng(1)
    time = pd.Index(np.arange(samples) * 0.01, name="time")
    signals = {"identification": _frame(time, 2, rng), "validation": pd.DataFrame(index=time)}
    estimates = {}
    biased = [0.63, 0.13, 0.62, 0.025, 0.010, -0.009, 0.051, 0.035]
    forward = [3.40, -0.68, 0.67, 0.064, 0.127, 0.006, -0.0066, 0.141]
    good = list(np.array(TRUTH) + np.array(SIGMA) * rng.standard_normal(8))
    for name, values, scale in (("WLS(1)", biased, 3), ("WLS(2)", forward, 1.5), ("WLS(3)", good, 1), ("RLS", good, 1)):
        estimates[name] = _estimate(name, "RLS" if name == "RLS" else "WLS", values, np.array(SIGMA) * scale)
    kept = [p for p in UNITS if p not in ("LMY2", "Fv1")]
    again = {p: estimates["WLS(3)"]["parameters"][p] for p in kept}
    dropped = [["LMY2", 900.0], ["Fv1", 37.0]]
    estimates["WLS(3)"]["essential"] = {"kept": kept, "dropped": dropped, "parameters": again}
    estimates["EKF(1)"] = {
        "status": "failed",
        "reason": SINGULAR,
        "method": "EKF",
        "tuning": "paper",
        "parameters": {},
        "elapsed_s": 0.002,
        "signals": None,
    }
    for name, tuning, shift in _filters():
        values = np.array(TRUTH) + np.array(SIGMA) * (rng.standard_normal(8) + shift)
        estimates[name] = _estimate(name, "EKF", values, SIGMA, tuning, COLOURED if tuning == "paper" else "")
        estimates[name]["tests"] = _tests(2, 0.005 if tuning == "paper" else 2.01)
        signals[slug(name)] = _filter(time, list(UNITS), values, SIGMA, signals["identification"], 2, rng)
    estimates["EKF(3) Euler"]["settings"]["transition"] = "Euler (Eq. 13)"
    _batch(estimates, signals, time, list(UNITS), 2, rng)
    return _record("scara", "Two-joint SCARA, simulated", "simulated", 2, estimates) | {"reference": _paper()}, signals


def emps(samples=24841):
    """(record, signals) like the measured EMPS drive's: 1 joint, 4 parameters, no truth, no figure numbers."""
    rng = np.random.default_rng(2)
    time = pd.Index(np.arange(samples) * 0.001, name="time")
    signals = {"identification": _frame(time, 1, rng, truth=False), "validation": pd.DataFrame(index=time)}
    units = dict(zip(("M", "Fv", "Fc", "offset"), ("kg", "N.s/m", "N", "N"), strict=True))
    a_priori, sigma = [95.0, 200.0, 20.0, -3.0], [0.11, 1.15, 0.1, 0.044]
    published = [95.1089, 203.5034, 20.3935, -3.1648]
    estimates = {}
    for name, method in (
        ("WLS(published)", "WLS"),
        ("WLS(house)", "WLS"),
        ("RLS", "RLS"),
        ("EKF(half)", "EKF"),
        ("EKF(one and a half)", "EKF"),
    ):
        values = np.array(published) + np.array(sigma) * rng.standard_normal(4)
        estimates[name] = _estimate(
            name,
            method,
            values,
            sigma,
            "derived" if method == "EKF" else None,
            "innovations are coloured (lag-1 correlation 0.98): σ is not calibrated" if method == "EKF" else "",
            units,
            a_priori,
            [None] * 4,
        )
        if method == "EKF":
            estimates[name]["tests"] = _tests(1, 1.1, white=False)
            signals[slug(name)] = _filter(time, list(units), values, sigma, signals["identification"], 1, rng)
    estimates["WLS(house)"]["essential"] = {"kept": list(units), "dropped": [], "parameters": {}}
    _batch(estimates, signals, time, list(units), 1, rng)
    for which in ("identification", "validation"):
        loop = {}
        for kind in ("q_1", "qd_1", "tau_1"):
            loop[kind] = np.sin(time.to_numpy()) + 1e-3 * rng.standard_normal(samples)
            loop[f"{kind} [simulated]"] = np.sin(time.to_numpy())
        signals[f"closed_loop_{which}"] = pd.DataFrame(loop, index=time)
    record = _record("emps", "EMPS drive, measured", "measured", 1, estimates, "m", "N")
    record["validation"]["closed_loop"] = {
        "identification": {"position": 0.0010, "velocity": 0.117, "force": 4.28},
        "validation": {"position": 0.0013, "velocity": 0.164, "force": 4.93},
    }
    columns = {
        p: {"value": v, "relative_sigma_percent": 100 * s / abs(v)}
        for p, v, s in zip(units, published, sigma, strict=True)
    }
    record["reference"] = {
        "source": "EMPS benchmark (Janot, Gautier, Brunot)",
        "tables": [
            {"title": "Published result", "estimates": {"published": {"ours": "WLS(published)", "parameters": columns}}}
        ],
    }
    return record, signals


def _filters():
    yield from (("EKF(2)", "paper", 20.0), ("EKF(3)", "paper", 8.0))
    for k in (2, 3):
        yield from ((f"EKF({k}) known", "known", 0.0), (f"EKF({k}) derived", "derived", 0.2))
    yield ("EKF(3) Euler", "known", 3.4)


def _estimate(name, method, values, sigma, tuning=None, reason="", units=UNITS, a_priori=TRUTH, truth=TRUTH):
    parameters = {}
    for p, value, s, prior, true in zip(units, values, sigma, a_priori, truth, strict=True):
        shown = None if reason else float(s)
        parameters[p] = {
            "value": float(value),
            "sigma": shown,
            "relative_sigma_percent": shown and 100 * shown / abs(value),
            "unit": units[p],
            "a_priori": prior,
            "truth": true,
            "start": 0.1 if method == "EKF" else None,
        }
    return {
        "status": "ok",
        "reason": "",
        "method": method,
        "tuning": tuning,
        "settings": {"cutoff": 15.0},
        "elapsed_s": {"WLS": 0.021, "RLS": 0.4}.get(method, 6.4),
        "fmu_calls": 312_500 if method == "EKF" else None,
        "condition_number": 231.4,
        "condition_number_Phi": 166.0,
        "sigma_reason": reason,
        "parameters": parameters,
        "tests": {},
        "signals": f"{slug(name)}.parquet",
    }


def _frame(time, joints, rng, truth=True):
    t, columns = time.to_numpy(), {}
    for j in range(1, joints + 1):
        q = 1.2 / j * np.sin(0.9 * t * j) + 0.5 * np.sin(2.3 * t + j)
        qd, qdd = np.gradient(q, t), np.gradient(np.gradient(q, t), t)
        tau = (3.4 if j == 1 else 0.07) * qdd + (0.6 if j == 1 else 0.16) * np.tanh(qd / 0.01)
        columns |= {
            f"q_{j}": q + 1e-3 * rng.standard_normal(len(t)),
            f"u_{j}": tau,
            f"tau_{j}": tau + (1.0 if j == 1 else 0.05) * rng.standard_normal(len(t)),
            f"q_{j} [filtered]": q,
            f"qd_{j} [filtered]": qd,
            f"qdd_{j} [filtered]": qdd,
        }
        if truth:
            columns |= {f"q_true_{j}": q, f"qd_true_{j}": qd, f"tau_true_{j}": tau}
    return pd.DataFrame(columns, index=time)


def _filter(time, names, values, sigma, frame, joints, rng):
    t, columns = time.to_numpy(), {}
    for j in range(1, joints + 1):
        columns |= {
            f"q_{j}": frame[f"q_{j} [filtered]"],
            f"qd_{j}": frame[f"qd_{j} [filtered]"] + 0.02 * rng.standard_normal(len(t)),
        }
        columns |= {
            f"sigma q_{j}": 5e-4 + 0 * t,
            f"sigma qd_{j}": 0.03 + 0 * t,
            f"innovation_{j}": 1e-3 * rng.standard_normal(len(t)),
            f"S_{j}": 1e-6 + 0 * t,
        }
    columns["NIS"] = rng.chisquare(joints, len(t))
    for p, value, s in zip(names, values, sigma, strict=True):
        decay = np.exp(-t / 2.5)
        columns[f"theta {p}"] = value + decay * (0.6 * abs(value) + 5 * s) * np.cos(1.7 * t)
        columns[f"sigma {p}"] = s + decay * (0.4 * abs(value) + 10 * s)
    return pd.DataFrame(columns, index=time)


def _batch(estimates, signals, time, names, joints, rng):
    """Signals of the least squares and what every estimate predicts on the validation run."""
    kept = time.to_numpy()[30:-30:10]
    frame = _frame(time, joints, rng)
    for j in range(1, joints + 1):
        signals["validation"][f"tau_{j}"] = frame[f"tau_{j}"]
    for name, e in estimates.items():
        if e["method"] == "WLS":
            residual = 0.1 * rng.standard_normal(joints * len(kept))
            rows = {"joint": np.repeat(np.arange(1, joints + 1), len(kept)), "y": residual + 1, "residual": residual}
            signals[slug(name)] = pd.DataFrame(rows, index=pd.Index(np.tile(kept, joints), name="time"))
        if e["method"] == "RLS":
            values = np.array([p["value"] for p in e["parameters"].values()])
            sigma = [p["sigma"] for p in e["parameters"].values()]
            signals[slug(name)] = _filter(
                pd.Index(kept, name="time"), names, values, sigma, frame.iloc[30:-30:10], joints, rng
            )
            signals[slug(name)] = signals[slug(name)].filter(regex="^(theta|sigma) [A-Z o]")
        if e["status"] == "ok":
            for j in range(1, joints + 1):
                signals["validation"][f"tau_{j} [{name}]"] = frame[f"tau_{j}"] * 0.99


def _tests(joints, nis, white=True):
    whiteness = [
        {"joint": j + 1, "lag1": 0.01 if white else 0.98, "outside_percent": 5.0 if white else 88.0, "ok": white}
        for j in range(joints)
    ]
    return {
        "NIS": {"mean": nis, "low": 0.91 * joints, "high": 1.09 * joints, "ok": 0.91 * joints <= nis <= 1.09 * joints},
        "whiteness": whiteness,
    }


def _record(name, title, kind, joints, estimates, position="rad", force="N.m"):
    excitation = {"condition_number_W": 231.4, "condition_number_Phi": 166.0, "singular_values": [812.0, 40.1, 3.5]}
    loop = _loop(joints, (2.11, 28.8)[joints == 1], [n for n, e in estimates.items() if e["method"] == "WLS"])
    return {
        "run_id": f"{name}-20261122-101500",
        "created": "2026-11-22T10:15:00+00:00",
        "title": title,
        "experiment": {
            "name": name,
            "title": title,
            "kind": kind,
            "seed": 1,
            "joints": joints,
            "joint_names": [f"joint {j + 1}" for j in range(joints)],
            "position_unit": position,
            "force_unit": force,
            "configuration": {"ekf": {"substeps": 4}},
        },
        "plant": {"fmu": f"{name}.fmu", "sha256": "c0ffee" * 10, "fmi_version": "2.0", "interface": "ME", "rung": "A"},
        "verdict": _verdict(),
        "excitation": excitation | {"left_out_of_Phi": ["LMY2"] if joints == 2 else [], "reference": excitation},
        "loop": loop,
        "estimates": estimates,
        "validation": _validation(joints, estimates),
        "findings": ["EKF(3) with the known noise and WLS(3) agree within 0.7 of their combined σ."],
        "timing": {"stages": {"simulate": 2.1, "identify": 31.0, "report": 1.2}, "estimates": {}},
        "provenance": {
            "command": f"fmuid run {name}",
            "versions": {"numpy": "2.4.6", "fmpy": "0.3.32"},
            "commit": "abc1234",
            "dirty": True,
            "python": "3.11.7",
            "platform": "Linux",
            "seed": 1,
            "engine": "compiled",
            "fmus": {name: {"sha256": "c0ffee" * 10, "guid": "{1234}"}},
        },
        "errors": [],
    }


def _loop(joints, f_dyn, names):
    f = np.geomspace(0.01, 20.0, 200) * f_dyn
    margin = {"gain": 8.3, "gain_at": 6 * f_dyn, "phase": 46.7, "phase_at": f_dyn, "modulus": 0.63, "modulus_at": f_dyn}
    one = {"q": [0.4] * joints, "u": [0.0] * joints, "bandwidth": [f_dyn] * joints, "margins": [margin] * joints}
    worst = {"phase": 39.9, "modulus": 0.61, "gain": None, "gain_at": None}
    two = {**one, "q": [2.36] * joints, "bandwidth": [1.2 * f_dyn] * joints, "margins": [margin | worst] * joints}
    curves = [list(1 / (1 + (f / (k * f_dyn)) ** 2)) for k in (1.0, 1.2)]
    filters = {
        "position": {"value": round(5 * f_dyn + 0.01, 1), "source": "5 f_dyn"},
        "parallel": {"value": 2 * f_dyn, "source": "set"},
        "decimation": {"value": 10, "source": "largest for the parallel cut-off"},
    }
    return {
        "f_dyn": f_dyn,
        "reason": "",
        "filters": dict.fromkeys(names, filters),
        "configurations": [one, two],
        "gain": {"f": list(f), "lowest": [curves[0]] * joints, "highest": [curves[1]] * joints},
    }


def _verdict():
    band = [1.82, 2.18]
    items = [
        {"name": "WLS, cond(W)", "value": 231.4, "limit": 250, "status": "pass"},
        {"name": "EKF(3) known, mean NIS", "value": 2.01, "limit": band, "status": "pass"},
        {"name": "EKF(2), paper's tuning, mean NIS", "value": 0.005, "limit": band, "status": "warn"},
    ]
    return {"status": "warn", "items": items}


def _validation(joints, estimates):
    names = [n for n, e in estimates.items() if e["status"] == "ok"]
    error = {f"tau_{j}": 4.03 + j for j in range(1, joints + 1)} | {"total": 4.2}
    floor = {f"tau_{j}": 4.01 for j in range(1, joints + 1)} | {"total": 4.0}
    runs = dict.fromkeys(("identification", "validation"), dict.fromkeys(names, error))
    own = {n: {"identification": 4.1, "validation": 6.0} for n in names if n.startswith("WLS")}
    return runs | {"noise_floor": floor, "own_filters": own}


def _paper():
    columns = {
        n: {"parameters": {p: {"value": v, "relative_sigma_percent": s} for p, v, s in zip(UNITS, *c, strict=True)}}
        for n, c in PAPER.items()
    }
    figures = {
        "torque": 4,
        "EKF(2)": {"states": [5, 6, 7, 8], "parameters": list(range(13, 21))},
        "EKF(3)": {"states": [9, 10, 11, 12], "parameters": list(range(21, 29))},
    }
    tables = [
        {"title": "Table 1: WLS estimation", "estimates": {n: columns[n] for n in ("WLS(1)", "WLS(2)", "WLS(3)")}},
        {
            "title": "Table 2: EKF estimation",
            "estimates": {
                "EKF(2)": columns["EKF(2)"],
                "EKF(3)": columns["EKF(3)"],
                "WLS": columns["WLS(3)"] | {"ours": "WLS(3)"},
            },
        },
    ]
    return {
        "source": "Gautier & Poignet 2001",
        "tables": tables,
        "figures": figures,
        "elapsed": {"WLS": 3, "EKF": 170, "machine": "Pentium II 233 MHz"},
        "metrics": {"condition_number_W": 290, "condition_number_Phi": 100},
    }
