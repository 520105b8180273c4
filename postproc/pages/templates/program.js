"use strict";
/* The path of a program: nominal, as it would be, as it will be, with the errors drawn larger; a click shows the line. */
(function () {
  const LADDER = [1, 2, 5];
  const view = {};

  const factor = (step) => LADDER[step % 3] * 10 ** Math.floor(step / 3);
  const place = (series, axis, part, times) => series.p[axis].map((v, i) => v + (part ? times * series[part][axis][i] / 1000 : 0));

  /* A curve along feeds: it is broken where a rapid leads to the next place. */
  function curve(series, axes, part, times) {
    const columns = axes.map((axis) => place(series, axis, part, times)), out = axes.map(() => []), index = [];
    for (let i = 0; i < series.s.length; i++) {
      if (i && !series.feed[i]) { out.forEach((column) => column.push(null)); index.push(null); }
      columns.forEach((column, k) => out[k].push(column[i]));
      index.push(i);
    }
    return { columns: out, index };
  }

  function axesOf(name) {
    const letters = gcomp.data.path.axes;
    return name === "3D" ? ["X", "Y", "Z"].map((x) => letters.indexOf(x)) : name.split(" ").map((x) => letters.indexOf(x));
  }

  function trace(axes, columns, more) {
    const solid = axes.length === 3;
    const own = { type: solid ? "scatter3d" : "scatter", x: columns[0], y: columns[1], hoverinfo: "skip", connectgaps: false };
    if (solid) own.z = columns[2];
    return Object.assign(own, more);
  }

  function quantity() {
    const path = gcomp.data.path, key = document.getElementById("colour").value;
    const series = key === "before" ? path.before : path.after;
    return { series, values: series[{ before: "d", after: "d", correction: "c", u: "u" }[key]], key };
  }

  function layer(axes, series, part, name, role, times, more) {
    const mode = gcomp.data.path.thinned ? "markers" : "lines";
    const drawn = curve(series, axes, part, times);
    const colour = gcomp.colour(role);
    return trace(axes, drawn.columns, Object.assign({ mode, name, line: { color: colour, width: 1.5 }, marker: { color: colour, size: 2.5 } }, more));
  }

  function traces() {
    const path = gcomp.data.path, axes = axesOf(view.name), times = factor(view.step);
    const { series, values } = quantity();
    const top = Math.max(...values, 1e-3);
    const solid = axes.length === 3, drawn = curve(series, axes, null, 0);
    const of = (column) => drawn.index.map((i) => (i === null ? null : column[i]));
    const hover = of(series.line.map((line, i) => `line ${line}: ${values[i].toFixed(2)} um`));
    const scale = {
      color: of(values).map((v) => (v === null ? 0 : v)), cmin: 0, cmax: top, colorscale: SEQUENTIAL, showscale: true,
      colorbar: { title: { text: "um", side: "top" }, thickness: gcomp.narrow() ? 8 : 12, len: 0.8, outlinewidth: 0 },
    };
    const coloured = solid && !path.thinned ? { mode: "lines", line: Object.assign({ width: 6 }, scale) }
      : { mode: "markers", marker: Object.assign({ size: solid ? 2.5 : 4 }, scale) };
    const list = [
      layer(axes, path.after, null, "nominal", "nominal", 0, { line: { color: gcomp.colour("nominal"), width: 1 } }),
      layer(axes, path.before, "off", "actual, not corrected", "before", times, {}),
      layer(axes, path.after, "off", "actual, corrected", "after", times, {}),
      layer(axes, path.after, "cmd", "commanded, corrected", "command", times, { visible: view.commanded ? true : "legendonly", line: { color: gcomp.colour("command"), width: 1.2, dash: "dot" } }),
      trace(axes, drawn.columns, Object.assign({
        name: "places", showlegend: false, text: hover, hovertemplate: "%{text}<extra></extra>", hoverinfo: undefined,
        customdata: of(series.line.map((line, i) => i)),
      }, coloured)),
    ];
    if (view.at !== null) {
      const spot = axes.map((axis) => [path.after.p[axis][view.at]]);
      list.push(trace(axes, spot, { mode: "markers", name: "the line told", showlegend: false, marker: { color: "rgba(0,0,0,0)", size: axes.length === 3 ? 8 : 16, line: { color: gcomp.colour("mark"), width: 2.5 } } }));
    }
    return list;
  }

  function layout(axes) {
    const path = gcomp.data.path, title = (axis, bare) => ({ text: path.axes[axis] + (bare ? "" : ", mm") });
    const grid = { gridcolor: "@grid", zerolinecolor: "@rule", linecolor: "@rule" };
    if (axes.length === 3) {
      /* Far enough off that the names of all three axes are in the picture. */
      const far = gcomp.narrow() ? 1.95 : 1.45;
      const camera = { eye: { x: far, y: far, z: far }, center: { x: 0, y: 0, z: -0.12 } };
      const scene = { aspectmode: "data", bgcolor: "rgba(0,0,0,0)", camera };
      ["xaxis", "yaxis", "zaxis"].forEach((name, k) => { scene[name] = Object.assign({ title: title(axes[k], gcomp.narrow()), color: "@ink", nticks: 6 }, grid); });
      return { scene, uirevision: view.name };
    }
    const flat = { uirevision: view.name };
    flat.xaxis = Object.assign({ title: title(axes[0]), automargin: true }, grid);
    flat.yaxis = Object.assign({ title: title(axes[1]), scaleanchor: "x", scaleratio: 1, automargin: true }, grid);
    return flat;
  }

  /* A flat path needs no high figure: both axes have one scale. */
  function heightOf(axes, width) {
    if (axes.length === 3) return Math.min(620, Math.max(360, width * 0.8));
    const path = gcomp.data.path, times = factor(view.step);
    const extent = axes.map((axis) => {
      const all = place(path.before, axis, "off", times).concat(path.after.p[axis]);
      return all.reduce((a, b) => Math.max(a, b), -Infinity) - all.reduce((a, b) => Math.min(a, b), Infinity);
    });
    const beside = gcomp.narrow() ? 210 : 110; // legend above, names below: in a narrow window the legend has four lines
    return Math.round(Math.min(620, Math.max(beside + 150, (width - 150) * extent[1] / Math.max(extent[0], 1e-6) + beside)));
  }

  function draw() {
    const node = document.getElementById("path"), axes = axesOf(view.name);
    document.getElementById("times").textContent = factor(view.step).toLocaleString("en");
    const height = heightOf(axes, node.clientWidth);
    node.style.height = height + "px";
    return Plotly.react(node, traces(), gcomp.layout(layout(axes), height, node), gcomp.config).then(() => {
      if (node.dataset.ready) return;
      node.dataset.ready = "1";
      node.on("plotly_click", (event) => {
        const point = event.points.find((p) => typeof p.customdata === "number");
        if (point) pickNear(point);
      });
    });
  }

  function pickNear(point) {
    const path = gcomp.data.path, { series } = quantity(), i = point.customdata;
    if (series === path.after) { tell(i); return; }
    const s = series.s[i];
    let best = 0;
    path.after.s.forEach((v, k) => { if (Math.abs(v - s) < Math.abs(path.after.s[best] - s)) best = k; });
    tell(best);
  }

  const escaped = (text) => text.replace(/[&<>]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" }[c]));

  function tell(i) {
    const path = gcomp.data.path, after = path.after;
    view.at = Math.max(0, Math.min(after.s.length - 1, i));
    const k = view.at, line = after.line[k], text = path.text[after.plain[k]] || ["", []];
    const moved = path.axes.map((x, a) => `${x} ${after.cmd[a][k] >= 0 ? "+" : ""}${after.cmd[a][k].toFixed(1)}`).join(", ");
    const own = Math.max(...path.before.d.filter((v, n) => path.before.line[n] === line), 0);
    const u = path.known ? ` The map is known to +- ${after.u[k].toFixed(1)} um here.` : "";
    document.getElementById("told").innerHTML =
      `<b>Line ${line}</b><pre>${escaped(text[0])}</pre>becomes<pre>${escaped(text[1].join("\n")) || "the same"}</pre>` +
      `Corrected by ${moved} um here; ${after.d[k].toFixed(2)} um remain. Not corrected, this line was up to ${own.toFixed(2)} um off.${u}`;
    draw();
  }

  gcomp.pick = function (line) {
    const after = gcomp.data.path.after;
    let best = -1;
    after.line.forEach((n, i) => { if (n === line && (best < 0 || after.d[i] > after.d[best])) best = i; });
    if (best < 0) return;
    tell(best);
    document.getElementById("viewer").scrollIntoView({ block: "nearest" });
  };

  gcomp.begin = function () {
    const path = gcomp.data.path, slider = document.getElementById("magnify");
    if (!path) return; /* nothing of this program is known to the map */
    Object.assign(view, { name: path.views[0], step: path.magnify, at: null, commanded: false });
    slider.value = view.step;
    slider.addEventListener("input", () => { view.step = Number(slider.value); draw(); });
    document.getElementById("view").addEventListener("change", (event) => {
      view.name = event.target.value;
      Plotly.purge("path");
      delete document.getElementById("path").dataset.ready;
      draw();
    });
    document.getElementById("colour").addEventListener("change", draw);
    const step = (by) => tell(view.at === null ? 0 : view.at + by);
    document.getElementById("back").addEventListener("click", () => step(-1));
    document.getElementById("forth").addEventListener("click", () => step(1));
    document.getElementById("path").addEventListener("keydown", (event) => {
      if (event.key === "ArrowRight") step(1); else if (event.key === "ArrowLeft") step(-1); else return;
      event.preventDefault();
    });
    gcomp.redraw.push(draw);
  };
})();
