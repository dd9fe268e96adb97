"""The page in a real browser: nothing leaves it, plots are made, zooms are linked, themes, print, small screens."""

import pytest

from pipeline.report.page import write_page
from pipeline.report.record import write_run
from tests.report import synthetic
from tests.report.test_page import EVIL

NAMES = ("scara", "emps")
DRAWN = "document.querySelectorAll('.plot[data-drawn]').length"
PLOTS = "document.querySelectorAll('.plot').length"


def until(page, expression):
    """Wait until a JavaScript expression holds (playwright's own waiting needs eval, which the page forbids)."""
    for _ in range(200):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"never came true: {expression}")


def scroll_through(page):
    """Open everything and bring every panel into view."""
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    height = page.evaluate("document.documentElement.scrollHeight")
    for y in range(0, height, 800):
        page.evaluate("(y) => scrollTo({top: y, behavior: 'instant'})", y)
        page.wait_for_timeout(60)
    until(page, f"{DRAWN} === {PLOTS}")


def show(page, key):
    page.evaluate("(k) => document.getElementById('p-' + k).scrollIntoView({behavior: 'instant'})", key)
    page.wait_for_selector(f"#p-{key}[data-drawn]")


@pytest.mark.parametrize("name", NAMES)
def test_every_plot_is_made_and_nothing_leaves_the_page(open_page, name):
    page = open_page(name)
    scroll_through(page)
    assert page.evaluate(PLOTS) > 20
    assert page.requests == [page.url]
    assert page.errors == []


def test_plots_wait_until_they_are_near(open_page):
    page = open_page("scara")
    page.wait_for_timeout(200)
    assert page.evaluate(DRAWN) == 0


def test_a_drag_zooms_the_others_too_those_made_later_included(open_page):
    page = open_page("scara")
    show(page, "force-1")
    box = page.locator("#p-force-1").bounding_box()
    x, y = box["x"], box["y"] + 60
    page.mouse.move(x + 200, y)
    page.mouse.down()
    page.mouse.move(x + 320, y, steps=6)
    page.mouse.up()
    until(page, "report.ranges.identification !== undefined")
    low, high = page.evaluate("report.ranges.identification")
    assert 0 < low < high < 25
    page.wait_for_timeout(150)
    shown = page.evaluate("Bokeh.documents.flatMap((d) => d.roots()).map((f) => [f.x_range.start, f.x_range.end])")
    assert len(shown) > 1
    for drawn in shown:
        assert drawn == pytest.approx([low, high])
    show(page, "course-ekf-2-0")
    page.wait_for_timeout(150)
    assert page.evaluate("report.rangeOf('course-ekf-2-0').slice(0, 2)") == pytest.approx([low, high])
    page.click("#whole")
    assert page.evaluate("report.ranges.identification === undefined")


def test_keys_move_and_zoom(open_page):
    page = open_page("scara")
    show(page, "force-1")
    page.focus("#p-force-1")
    page.keyboard.press("+")
    low, high = page.evaluate("report.ranges.identification")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("report.ranges.identification[0]") > low
    page.keyboard.press("0")
    assert page.evaluate("report.ranges.identification === undefined")
    assert high - low < 25 * 0.75


def test_a_gain_is_drawn_over_decades_and_both_joints_zoom_together(open_page):
    page = open_page("scara")
    show(page, "loop-1")
    axes = "Bokeh.documents.flatMap((d) => d.roots()).map((f) => [f.below[0].axis_label, f.below[0].type])"
    assert {kind for label, kind in page.evaluate(axes) if label == "Frequency in Hz"} == {"LogAxis"}
    low, high = page.evaluate("report.rangeOf('loop-1').slice(0, 2)")
    assert low == pytest.approx(0.0211, rel=1e-3) and high == pytest.approx(42.2, rel=1e-3)
    page.evaluate("report.setRange('loop', 1, 10)")
    assert page.evaluate("report.rangeOf('loop-2').slice(0, 2)") == [1, 10]
    page.emulate_media(media="print")
    page.wait_for_selector("#p-loop-2 + svg.paper", state="attached")
    ticks = "[...document.querySelectorAll('#p-loop-2 + svg.paper text')].map((t) => t.textContent)"
    assert {"1", "2", "5", "10"} <= set(page.evaluate(ticks))
    assert page.errors == []


def test_the_legend_hides_a_series(open_page):
    page = open_page("scara")
    show(page, "course-ekf-2-0")
    key = page.locator("figure:has(#p-course-ekf-2-0) .key").first
    key.click()
    assert key.get_attribute("aria-pressed") == "false"
    hidden = "report.panels.find((p) => p.spec.key === 'course-ekf-2-0').hidden"
    assert page.evaluate(hidden)[0] is True
    hint = "getComputedStyle(document.querySelector('.key[aria-pressed=false]'), '::after').content"
    assert page.evaluate(hint) == '"(hidden: click to show)"'


def test_the_marks_of_a_gain_are_drawn_in_three_dashes(open_page):
    page = open_page("scara")
    show(page, "loop-1")
    gains = "Bokeh.documents.flatMap((d) => d.roots()).filter((f) => f.below[0].axis_label === 'Frequency in Hz')"
    drawn = f"{gains}[0].renderers.map((r) => r.glyph.line_dash?.value?.join()).filter(Boolean)"
    assert len(set(page.evaluate(drawn))) == 3
    page.emulate_media(media="print")
    page.wait_for_selector("#p-loop-1 + svg.paper", state="attached")
    dashed = "[...document.querySelectorAll('#p-loop-1 + svg.paper path[stroke-dasharray]')]"
    assert len(set(page.evaluate(f"{dashed}.map((p) => p.getAttribute('stroke-dasharray'))"))) == 3
    assert page.errors == []


def test_values_under_the_pointer_are_read_out(open_page):
    page = open_page("scara")
    show(page, "force-1")
    box = page.locator("#p-force-1").bounding_box()
    page.mouse.move(box["x"] + 250, box["y"] + 80)
    until(page, "document.querySelector('figure:has(#p-force-1) .readout').textContent !== ''")


def luminance(page, selector, what):
    script = "([s, w]) => getComputedStyle(document.querySelector(s))[w].match(/[\\d.]+/g).slice(0, 3).map(Number)"
    red, green, blue = page.evaluate(script, [selector, what])
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_dark_and_light_follow_the_system_and_the_button(open_page):
    page = open_page("scara", color_scheme="dark")
    assert luminance(page, "body", "backgroundColor") < 40 < 200 < luminance(page, "body", "color")
    show(page, "force-1")
    colour = "Bokeh.documents[0].roots()[0].below[0].major_label_text_color"
    dark = page.evaluate(colour)
    page.click("#theme")
    assert luminance(page, "body", "backgroundColor") > 200
    show(page, "force-1")
    until(page, "Bokeh.documents.length > 0")
    assert page.evaluate(colour.replace("documents[0]", "documents.at(-1)")) != dark


def test_print_has_every_panel_and_is_light(open_page):
    page = open_page("scara", color_scheme="dark")
    page.emulate_media(media="print", color_scheme="dark")
    page.wait_for_selector("svg.paper", state="attached")
    assert page.evaluate("document.querySelectorAll('svg.paper').length") == page.evaluate(PLOTS)
    assert page.evaluate(
        "[...document.querySelectorAll('svg.paper')].every((s) => s.getBoundingClientRect().height > 50)"
    )
    assert luminance(page, "body", "color") < 80
    page.emulate_media(media="screen")
    page.wait_for_selector("svg.paper", state="detached")
    assert not page.evaluate("document.querySelector('details.more').open")


def test_a_pdf_has_its_curves(open_page, tmp_path):
    page = open_page("emps")
    page.pdf(path=tmp_path / "page.pdf", prefer_css_page_size=True)
    assert (tmp_path / "page.pdf").stat().st_size > 200_000


@pytest.mark.parametrize("name", NAMES)
def test_a_small_screen_needs_no_sideways_scrolling(open_page, name):
    page = open_page(name, viewport={"width": 375, "height": 700})
    scroll_through(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 375


def test_names_are_inert_in_the_browser(open_page, tmp_path):
    record, signals = synthetic.scara(samples=50)
    for estimate in record["estimates"].values():
        estimate["parameters"] = {p.replace("ZZR1", EVIL): v for p, v in estimate["parameters"].items()}
    for table in signals.values():
        table.columns = [c.replace("ZZR1", EVIL) for c in table.columns]
    write_page(write_run(tmp_path / "evil", record, signals))
    page = open_page(tmp_path / "evil")
    scroll_through(page)
    page.emulate_media(media="print")
    page.wait_for_selector("svg.paper", state="attached")
    assert page.evaluate("document.images.length") == 0
    assert page.requests == [page.url]
    assert page.errors == []
