// The page's own behaviour: panels made when they come into view, x ranges that move together, legend, keys, theme, print.
"use strict";

(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const decoded = new Map();
  const ranges = {};   // link group → [x0, x1], or absent for all of it
  const panels = data.panels.map(prepare);

  function array(name) {
    if (!decoded.has(name)) {
      const bytes = Uint8Array.from(atob(data.arrays[name]), (c) => c.charCodeAt(0));
      decoded.set(name, new Float32Array(bytes.buffer));
    }
    return decoded.get(name);
  }

  function prepare(spec) {
    const host = document.getElementById(`p-${spec.key}`);
    return {spec, host, plot: null, visible: false, stale: false, hidden: spec.series.map((s) => !!s.hidden)};
  }

  // The panel with its arrays, decoded when first asked for.
  function full(panel) {
    panel.full ??= {...panel.spec, series: panel.spec.series.map((s) => {
      const series = {...s};
      for (const key of ["x", "y", "half"]) if (typeof s[key] === "string") series[key] = array(s[key]);
      return series;
    })};
    return panel.full;
  }

  // ---- ranges
  const extents = {};
  function extent(panel) {
    const key = panel.spec.link || panel.spec.key;
    if (!extents[key]) {
      let low = Infinity, high = -Infinity;
      for (const other of panels) {
        if ((other.spec.link || other.spec.key) !== key) continue;
        for (const series of other.spec.series) {
          if (!series.x) continue;
          const x = array(series.x), pad = (series.width || 0) / 2;
          for (const value of x) { low = Math.min(low, value - pad); high = Math.max(high, value + pad); }
        }
      }
      extents[key] = high > low ? [low, high] : [0, 1];
    }
    return extents[key];
  }

  function rangeOf(panel) {
    const group = panel.spec.link || panel.spec.key;
    const x = ranges[group] || extent(panel);
    return [...x, ...(ranges[group] ? fitted(panel, x) : panel.spec.range || fitted(panel, x))];
  }

  // The y range of what is shown inside an x range, bands included.
  function fitted(panel, [x0, x1]) {
    let low = Infinity, high = -Infinity;
    const take = (y) => { if (y < low) low = y; if (y > high) high = y; };
    full(panel).series.forEach((series, index) => {
      if (panel.hidden[index]) return;
      if (series.kind === "level") { if (!ranges[panel.spec.link]) series.y.forEach(take); return; }
      if (series.kind === "bars") take(0);
      series.x.forEach((x, k) => {
        if (x < x0 || x > x1 || !Number.isFinite(series.y[k])) return;
        const half = series.half && Number.isFinite(series.half[k]) ? series.half[k] : 0;
        take(series.y[k] - half);
        take(series.y[k] + half);
      });
    });
    if (!(high >= low)) return panel.spec.range || [-1, 1];
    const pad = 0.06 * ((high - low) || Math.abs(high) || 1);
    return [low - pad, high + pad];
  }

  function setRange(group, x0, x1) {
    if (x1 > x0) ranges[group] = [x0, x1]; else delete ranges[group];
    for (const panel of panels) {
      if ((panel.spec.link || panel.spec.key) !== group || !panel.plot) continue;
      panel.stale = true;
      if (panel.visible) refresh(panel);
    }
    document.getElementById("whole").hidden = Object.keys(ranges).length === 0;
  }

  function refresh(panel) {
    panel.stale = false;
    panel.plot.setRange(...rangeOf(panel));
  }

  function showAll() {
    for (const group of Object.keys(ranges)) setRange(group, 0, 0);
  }

  // ---- plots
  function make(panel) {
    const group = panel.spec.link || panel.spec.key;
    let pending = 0;
    panel.plot = drawPlot(panel.host, full(panel), look(), rangeOf(panel), {
      range(x0, x1) {
        cancelAnimationFrame(pending);
        pending = requestAnimationFrame(() => setRange(group, x0, x1));
      },
      hover: (x) => hover(group, x),
      reset: () => setRange(group, 0, 0),
    });
    panel.hidden.forEach((hidden, index) => panel.plot.show(index, !hidden));
  }

  function remake() {
    style = null;
    for (const panel of panels) {
      if (!panel.plot) continue;
      panel.plot.remove();
      panel.plot = null;
      if (panel.visible) make(panel);
    }
  }

  // Colours as the style sheet has them in the theme of the moment, resolved for a canvas.
  let style = null;
  function look() {
    if (style) return style;
    const probe = document.body.appendChild(document.createElement("span"));
    const resolved = (name) => {
      probe.style.color = `var(--${name})`;
      return getComputedStyle(probe).color;
    };
    const names = new Set(data.panels.flatMap((p) => p.series.map((s) => s.colour)));
    const palette = Object.fromEntries([...names].map((name) => [name, resolved(`c-${name}`)]));
    const [muted, line, grid] = ["muted", "line", "grid"].map(resolved);
    probe.remove();
    style = {colour: (name) => palette[name], muted, line, grid, font: getComputedStyle(document.body).fontFamily};
    return style;
  }

  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      const panel = panels.find((p) => p.host === entry.target);
      panel.visible = entry.isIntersecting;
      if (panel.visible && !panel.plot) make(panel);
      else if (panel.visible && panel.stale) refresh(panel);
    }
  }, {rootMargin: "200px"});

  // ---- values under the pointer
  let hovered = 0;
  function hover(group, x) {
    cancelAnimationFrame(hovered);
    hovered = requestAnimationFrame(() => {
      for (const panel of panels) {
        if ((panel.spec.link || panel.spec.key) !== group || !panel.plot || !panel.visible) continue;
        panel.plot.mark(x);
        const outputs = panel.host.closest("figure").querySelectorAll(".readout");
        full(panel).series.forEach((series, index) => { outputs[index].textContent = x === null ? "" : reading(series, x); });
      }
    });
  }

  // Value ± sigma, as in the tables: half a band is two sigma.
  function reading(series, x) {
    if (series.kind === "level") return series.y.length === 1 ? tickText(Number(series.y[0].toPrecision(4))) : "";
    const at = nearest(series.x, x);
    const half = series.half ? ` ± ${tickText(Number((series.half[at] / 2).toPrecision(2)))}` : "";
    return tickText(Number(series.y[at].toPrecision(4))) + half;
  }

  function nearest(xs, x) {
    let low = 0, high = xs.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] > x) high = middle; else low = middle;
    }
    return x - xs[low] > xs[high] - x ? high : low;
  }

  // ---- keys, wheel, legend
  function zoomed(panel, factor, shift, at) {
    const [x0, x1] = ranges[panel.spec.link || panel.spec.key] || extent(panel);
    const centre = at ?? (x0 + x1) / 2;
    const [low, high] = [centre - (centre - x0) * factor, centre + (x1 - centre) * factor];
    const [first, last] = extent(panel);
    const move = shift * (high - low);
    setRange(panel.spec.link || panel.spec.key, Math.max(first, low + move), Math.min(last, high + move));
  }

  for (const panel of panels) {
    observer.observe(panel.host);
    panel.host.addEventListener("keydown", (event) => {
      const act = {ArrowLeft: [1, -0.2], ArrowRight: [1, 0.2], "+": [0.7, 0], "=": [0.7, 0], "-": [1 / 0.7, 0]}[event.key];
      if (act) zoomed(panel, ...act);
      else if (event.key === "0" || event.key === "Escape") setRange(panel.spec.link || panel.spec.key, 0, 0);
      else return;
      event.preventDefault();
    });
    panel.host.closest("figure").addEventListener("click", (event) => {
      const key = event.target.closest(".key");
      if (!key) return;
      const index = Number(key.dataset.series);
      panel.hidden[index] = !panel.hidden[index];
      key.setAttribute("aria-pressed", String(!panel.hidden[index]));
      if (panel.plot) { panel.plot.show(index, !panel.hidden[index]); refresh(panel); }
    });
  }
  document.getElementById("whole").addEventListener("click", showAll);

  // ---- theme: the system's, unless the reader chose
  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  document.getElementById("theme").addEventListener("click", () => {
    const now = root.dataset.theme || (dark.matches ? "dark" : "light");
    root.dataset.theme = now === "dark" ? "light" : "dark";
    remake();
  });
  dark.addEventListener("change", remake);

  // ---- print: everything opened, every panel as SVG
  let opened = null;
  function beforePrint() {
    if (opened) return;
    opened = [...document.querySelectorAll("details:not([open]):not(.numbers)")];
    for (const element of opened) element.open = true;
    for (const panel of panels) {
      panel.host.insertAdjacentHTML("afterend", svgPlot(full(panel), panel.hidden, rangeOf(panel)));
    }
  }
  function afterPrint() {
    if (!opened) return;
    for (const element of opened) element.open = false;
    for (const element of document.querySelectorAll("svg.paper")) element.remove();
    opened = null;
  }
  addEventListener("beforeprint", beforePrint);
  addEventListener("afterprint", afterPrint);
  matchMedia("print").addEventListener("change", (event) => (event.matches ? beforePrint : afterPrint)());

  window.report = {panels, ranges, setRange, rangeOf: (key) => rangeOf(panels.find((p) => p.spec.key === key))};
})();
