"""The page as text: valid, complete, deterministic, honest, inert to names, and whole where the run is not."""

import copy
import json
import re

import html5lib
import pytest

from pipeline.errors import DataError
from pipeline.report import intervals
from pipeline.report.page import page, write_page
from pipeline.report.provenance import flat
from pipeline.report.record import read_run
from tests.report import synthetic

NAMES = ("scara", "emps")
EVIL = "</script><img src=x onerror=alert(1)><b>&\"'"


def tree(text):
    return html5lib.HTMLParser(strict=True, namespaceHTMLElements=False).parse(text)


def words(element) -> str:
    return " ".join(" ".join(element.itertext()).split())


def section(text, id):
    return next(e for e in tree(text).iter("section") if e.get("id") == id)


@pytest.fixture(scope="module")
def texts(runs):
    return {name: (runs(name) / "index.html").read_text() for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_the_page_is_valid_and_its_ids_are_unique(texts, name):
    ids = [e.get("id") for e in tree(texts[name]).iter() if e.get("id")]
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("name", NAMES)
def test_labels_and_links_lead_somewhere(texts, name):
    elements = list(tree(texts[name]).iter())
    ids = {e.get("id") for e in elements}
    assert {e.get("aria-labelledby") for e in elements} - {None} <= ids
    assert {e.get("href")[1:] for e in elements if e.tag == "a"} <= ids


@pytest.mark.parametrize("name", NAMES)
def test_the_page_stays_below_4_MB(texts, name):
    assert len(texts[name].encode()) <= 4_000_000


@pytest.mark.parametrize("name", NAMES)
def test_the_same_record_gives_the_same_bytes(runs, texts, name):
    assert page(*read_run(runs(name))) == texts[name]


def test_the_verdict_comes_first_and_stands_in_the_title(texts):
    root = tree(texts["scara"])
    assert words(root.find(".//title")).startswith("WARN: Two-joint SCARA")
    first = next(iter(root.find(".//main")))
    assert first.get("id") == "verdict"
    assert "WARN Of 3 checks: 1 to watch." in words(first)
    assert "WARN EKF(2), paper's tuning, mean NIS 0.005 1.82 … 2.18" in words(first)


def test_beside_the_verdict_stands_what_failed_and_what_has_no_sigma(texts):
    root = section(texts["scara"], "verdict")
    record = synthetic.scara(samples=50)[0]["estimates"]
    failed = [n for n, e in record.items() if e["status"] != "ok"]
    bare = [n for n, e in record.items() if e["status"] == "ok" and e["sigma_reason"]]
    folded = next(e for e in root.iter("details") if e.get("class") == "without")
    left = len(record) - len(failed)
    assert words(folded.find("summary")) == (
        f"{len(failed)} of {len(record)} estimates failed; σ is withheld for {len(bare)} of the other {left}"
    )
    assert words(folded).endswith(f"Failed : {', '.join(failed)} σ withheld : {', '.join(bare)}")
    record, signals = synthetic.scara(samples=50)
    record["estimates"] = {n: e for n, e in record["estimates"].items() if n not in failed + bare}
    assert 'class="without"' not in page(record, signals)


@pytest.mark.parametrize(("status", "word"), [("pass", "PASS"), ("fail", "FAIL"), ("nonsense", "FAIL")])
def test_every_verdict_has_its_word(status, word):
    record, signals = synthetic.scara(samples=50)
    record["verdict"] = {"status": status, "items": []}
    text = page(record, signals)
    assert f"<title>{word}: " in text
    assert word in words(section(text, "verdict"))


def test_every_figure_of_the_paper_has_its_panel(texts):
    titles = [words(e) for e in tree(texts["scara"]).iter("h4")]
    for figure in range(4, 29):
        assert any(t.startswith(f"Fig. {figure}: ") for t in titles), figure
    assert "Fig. 13: ZZR1, EKF(2)" in titles
    assert "Fig. 28: Fs2, EKF(3)" in titles
    assert "Fig. 6: Joint 1, velocity, EKF(2)" in titles


def test_without_figure_numbers_the_titles_are_plain(texts):
    titles = [words(e) for e in tree(texts["emps"]).iter("h4")]
    assert not any(t.startswith("Fig.") for t in titles)
    assert "M, EKF(half)" in titles


@pytest.mark.parametrize("name", NAMES)
def test_every_panel_has_a_caption_of_good_and_bad(texts, name):
    panels = [e for e in tree(texts[name]).iter("figure") if e.get("class") == "panel"]
    assert len(panels) > 20
    for panel in panels:
        caption = words(panel.find("figcaption"))
        assert "Good: " in caption, words(panel.find("h4"))
        assert "Bad: " in caption, words(panel.find("h4"))


def test_the_printed_table_stands_beside_ours(texts):
    tables = {words(f.find("h4")): words(f) for f in tree(texts["scara"]).iter("figure") if f.get("class") == "sheet"}
    first, second = tables["Table 1: WLS estimation"], tables["Table 2: EKF estimation"]
    assert re.search(r"ZZR1 kg·m² 3\.42 3\.42 0\.51 4\.8 0\.630 0\.025", first)
    assert "WLS (ours: WLS(3))" in second
    assert second.count("σ withheld : mean NIS 0.005 is below its band") == 2


def test_a_withheld_sigma_is_nowhere_shown_as_a_number(texts):
    rows = [e for e in tree(texts["emps"]).iter() if e.tag.endswith("}g") and "EKF(half)" in words(e)]
    assert len(rows) == 4
    assert not any("±" in words(row) for row in rows)


def test_a_failed_estimate_shows_its_reason_and_no_number(texts):
    parameters = words(section(texts["scara"], "parameters"))
    assert f"EKF(1) failed : {synthetic.SINGULAR}" in parameters
    assert parameters.count("EKF(1) failed") == 1 + len(synthetic.UNITS)


def test_essential_parameters_and_what_was_left_out(texts):
    assert re.search(
        r"Fv1 N·m·s/rad 0\.\d+ ± 0\.026 0\.07 left out, 37 %", words(section(texts["scara"], "parameters"))
    )
    assert "Essential parameters" not in words(section(texts["emps"], "parameters"))


def test_a_long_reason_is_cut_in_the_table_and_whole_below():
    record, signals = synthetic.scara(samples=50)
    record["estimates"]["EKF(2)"]["sigma_reason"] = "mean NIS is low; joint 1 is coloured; joint 2 is too"
    parameters = words(section(page(record, signals), "parameters"))
    assert "σ withheld : mean NIS is low …" in parameters
    assert "EKF(2) : mean NIS is low; joint 1 is coloured; joint 2 is too" in parameters


def test_a_long_reason_of_one_clause_is_cut_and_whole_below_too():
    record, signals = synthetic.scara(samples=50)
    why = "joint 1: the residual is coloured, autocorrelation 0.95 at 0.05 s (limit 0.15): biased by noise in W"
    record["estimates"]["WLS(1)"]["sigma_reason"] = why
    tables = {words(f.find("h4")): words(f) for f in tree(page(record, signals)).iter("figure")}
    first = tables["Table 1: WLS estimation"]
    assert "σ withheld : joint 1: the residual is coloured, autocorrelation 0.95 at 0.05 s …" in first
    assert first.endswith(f"WLS(1) : {why}")


def test_ticks_leave_room_for_their_labels():
    for low, high in (
        (0.0633, 0.0647),
        (0.0, 1.0),
        (-123456.0, 123457.0),
        (3.4197, 3.42031),
        (-1.0, 1.0),
        (1e-7, 2e-7),
    ):
        ticks = intervals._ticks(low, high)
        places = [intervals.PLOT * (v - low) / (high - low) for v in ticks]
        widths = [5.9 * len(intervals._shown(v)) for v in ticks]
        assert ticks and all(low <= v <= high for v in ticks)
        for k in range(len(ticks) - 1):
            assert places[k + 1] - places[k] > (widths[k] + widths[k + 1]) / 2
    assert [round(v, 6) for v in intervals._ticks(0.06305, 0.06495)] == [0.0635, 0.0645]
    assert intervals._ticks(-1.0, 1.0) == [-1.0, -0.5, 0.0, 0.5, 1.0]


def test_the_marks_of_the_loop_have_dashes_of_their_own_and_the_legend_says_it_can_be_clicked(texts):
    figure = next(
        e for e in tree(texts["scara"]).iter("figure") if words(e.find("h4")).endswith("reference to position")
    )
    keys = {words(k): k for k in figure.iter("button")}
    dashes = [keys[k].find(".//*[@stroke-dasharray]").get("stroke-dasharray") for k in ("f_dyn", "2 f_dyn", "5 f_dyn")]
    assert len(set(dashes)) == 3 and None not in dashes
    assert {k.get("title") for k in keys.values()} == {"Click to hide or show"}


def test_settings_are_told_in_lines():
    settings = {"ekf": {"case": [{"R": [1e-6, 2]}, {"name": "x"}]}, "seed": 1, "empty": {}}
    assert flat(settings) == ["ekf.case[0].R = [1e-06, 2]", 'ekf.case[1].name = "x"', "seed = 1"]


def test_names_are_inert():
    record, signals = synthetic.scara(samples=50)
    record = json.loads(json.dumps(record).replace("ZZR1", "Evil0"))
    for table in signals.values():
        table.columns = [c.replace("ZZR1", EVIL) for c in table.columns]
    record["estimates"] = {
        name.replace("EKF(2)", f"EKF(2){EVIL}"): e
        | {"parameters": {p.replace("Evil0", EVIL): v for p, v in e["parameters"].items()}, "reason": EVIL}
        for name, e in record["estimates"].items()
    }
    record["findings"], record["title"], record["errors"] = [EVIL], EVIL, [{"stage": EVIL, "message": EVIL}]
    record["provenance"]["command"] = record["run_id"] = EVIL
    record["experiment"]["configuration"] = {EVIL: EVIL}
    root = tree(page(record, signals))
    assert not list(root.iter("img"))
    assert len(list(root.iter("script"))) == 5
    assert EVIL in words(root.find(".//h1"))


def test_a_stage_that_failed_is_told_and_the_rest_stays():
    record, signals = synthetic.scara(samples=50)
    record["errors"] = [{"stage": "EKF", "message": "FMU scara.fmu: fmi2GetReal returned error at 0.01 s"}]
    for key in ("validation", "findings", "reference", "timing"):
        del record[key]
    text = page(record, {"identification": signals["identification"]})
    assert "fmi2GetReal returned error at 0.01 s" in words(section(text, "errors"))
    assert "1 stage failed." in words(section(text, "verdict"))
    assert "closed-loop" not in {e.get("id") for e in tree(text).iter("section")}


def test_a_record_of_the_bare_minimum_makes_a_page():
    record = {"run_id": "r", "experiment": {}, "verdict": {}, "estimates": {}}
    assert "FAIL" in words(section(page(record, {}), "verdict"))


def test_a_filter_that_failed_on_its_way_shows_how_far_it_came():
    record, signals = synthetic.scara(samples=400)
    record, signals = copy.deepcopy(record), dict(signals)
    record["estimates"]["EKF(2)"] |= {"status": "failed", "reason": "M is not positive definite at 2.00 s"}
    signals["ekf-2"] = signals["ekf-2"].iloc[:200]
    signals["ekf-3"] = signals["ekf-3"].iloc[:0]
    text = page(record, signals)
    tree(text)
    titles = [words(e) for e in tree(text).iter("h4")]
    assert "Fig. 13: ZZR1, EKF(2)" in titles
    assert "Fig. 21: ZZR1, EKF(3)" not in titles


def test_a_broken_folder_is_one_line(tmp_path):
    with pytest.raises(DataError, match="not found"):
        write_page(tmp_path / "nowhere")


def test_the_loop_shows_the_worst_margins_and_where_each_cutoff_comes_from(texts):
    text = words(section(texts["scara"], "loop"))
    assert "Joint 2 2.11 to 2.53 39.9° 2.11 Hz 8.30 (18.4 dB) 0.61 2.4, 2.4 rad" in text
    assert "f_dyn = 2.11 Hz" in text and "median over 2 configurations" in text
    assert "WLS(3) 10.6 Hz, 5 f_dyn 4.22 Hz, set 1 of 10, largest for the parallel cut-off" in text
    assert "28.8 to 34.6" in words(section(texts["emps"], "loop"))


def test_a_loop_that_could_not_be_analysed_says_why():
    record, signals = synthetic.emps(samples=50)
    filters = record["loop"]["filters"]
    record["loop"] = {"f_dyn": None, "reason": "the experiment has no [controller]", "filters": filters}
    text = words(section(page(record, signals), "loop"))
    assert "No loop was analysed: the experiment has no [controller]." in text and "WLS(house)" in text
    del record["loop"]
    assert not any(e.get("id") == "loop" for e in tree(page(record, signals)).iter("section"))


def test_filters_that_differentiate_alike_share_a_row():
    record, signals = synthetic.scara()
    one = {"used": "directional", "against": "central", "difference": 3.2e-6, "reason": ""}
    for name in ("EKF(2)", "EKF(3)"):
        record["estimates"][name]["jacobian"] = one
    record["estimates"]["EKF(3) known"]["jacobian"] = {**one, "used": "forward", "reason": "the FMU provides none"}
    text = words(section(page(record, signals), "innovations"))
    assert "EKF(2), EKF(3) – directional central 3.2e−6 –" in text
    assert "EKF(3) known – forward central 3.2e−6 the FMU provides none" in text
