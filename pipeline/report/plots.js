// The layer over BokehJS: drawPlot() is all that page.js knows of it. Another library takes its place here.
"use strict";

Bokeh.logger.set_level("error");

// host: element; spec: a panel of pipeline/report/panels.py with its arrays decoded; look: colours and font;
// on: {range(x0, x1), hover(x or null), reset()}. Returns {setRange, show, mark, remove}.
function drawPlot(host, spec, look, range, on) {
  const x_range = new Bokeh.Range1d({start: range[0], end: range[1]});
  const y_range = new Bokeh.Range1d({start: range[2], end: range[3]});
  const figure = Bokeh.Plotting.figure({
    x_range, y_range, x_axis_type: spec.log ? "log" : "linear", tools: "", toolbar_location: null, sizing_mode: "stretch_both", min_border_left: 58,
    min_border_right: 8, min_border_top: 4, min_border_bottom: 40, background_fill_color: null, border_fill_color: null,
    outline_line_color: null,
  });
  styleAxes(figure, spec, look);
  const bands = spec.series.filter((series) => series.half).length;
  const alpha = Math.min(0.2, 0.4 / Math.max(bands, 1));
  const glyphs = spec.series.map((series) => addSeries(figure, series, look, alpha));
  const cursor = new Bokeh.Span({location: 0, dimension: "height", line_color: look.muted, line_width: 1, visible: false});
  figure.add_layout(cursor);
  if (!matchMedia("(pointer: coarse)").matches) {
    const box = new Bokeh.BoxZoomTool({dimensions: "width"});
    figure.add_tools(box);
    figure.toolbar.active_drag = box;
  }
  let silent = false, removed = false, view = null;
  x_range.change.connect(() => { if (!silent) on.range(x_range.start, x_range.end); });
  figure.on_event("mousemove", (event) => on.hover(event.x));
  figure.on_event("mouseleave", () => on.hover(null));
  figure.on_event("doubletap", () => on.reset());
  Bokeh.Plotting.show(figure, host).then((shown) => {
    view = shown;
    if (removed) view.remove(); else host.dataset.drawn = "yes";
  });
  return {
    setRange(x0, x1, y0, y1) {
      silent = true;
      x_range.setv({start: x0, end: x1});
      y_range.setv({start: y0, end: y1});
      silent = false;
    },
    show(index, visible) { for (const glyph of glyphs[index]) glyph.visible = visible; },
    mark(x) { cursor.setv(x === null ? {visible: false} : {location: x, visible: true}); },
    remove() {
      removed = true;
      delete host.dataset.drawn;
      if (view) view.remove();
      host.replaceChildren();
    },
  };
}

function styleAxes(figure, spec, look) {
  const text = {text_color: look.muted, text_font: look.font, text_font_size: "11px"};
  const named = (prefix) => Object.fromEntries(Object.entries(text).map(([key, value]) => [`${prefix}_${key}`, value]));
  const axis = {
    ...named("axis_label"), ...named("major_label"), axis_label_text_font_style: "normal", axis_label_standoff: 6,
    axis_line_color: look.line, major_tick_line_color: look.line, minor_tick_line_color: null, major_tick_in: 0,
    major_tick_out: 4,
  };
  for (const [model, label] of [[figure.below[0], spec.x], [figure.left[0], spec.y]]) model.setv({...axis, axis_label: label});
  for (const model of figure.center) {
    if ("grid_line_color" in model) model.setv({grid_line_color: look.grid, grid_line_width: 1});
  }
}

function addSeries(figure, series, look, alpha) {
  const colour = look.colour(series.colour);
  const dash = series.kind === "level" ? [5, 4] : series.dash || [];
  const visible = !series.hidden;
  if (series.kind === "level") {
    const style = {dimension: "width", line_color: colour, line_dash: dash, line_width: 1.3};
    const spans = series.y.map((location) => new Bokeh.Span({...style, location}));
    for (const span of spans) figure.add_layout(span);
    return spans;
  }
  const source = new Bokeh.ColumnDataSource({data: {x: series.x, y: series.y}});
  if (series.kind === "bars") {
    const bars = {x: {field: "x"}, top: {field: "y"}, bottom: 0, width: series.width, source};
    return [figure.vbar({...bars, fill_color: colour, fill_alpha: 0.75, line_color: null, visible})];
  }
  const drawn = [];
  if (series.half) {
    source.data = {...source.data, low: edge(series, -1), high: edge(series, 1)};
    const band = {x: {field: "x"}, y1: {field: "low"}, y2: {field: "high"}, source};
    drawn.push(figure.varea({...band, fill_color: colour, fill_alpha: alpha, visible}));
  }
  const line = {x: {field: "x"}, y: {field: "y"}, source};
  drawn.push(figure.line({...line, line_color: colour, line_width: series.wide ? 3.2 : 1.4, line_dash: dash, visible}));
  return drawn;
}

function edge(series, sign) {
  return series.y.map((value, index) => value + sign * series.half[index]);
}
