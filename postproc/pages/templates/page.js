"use strict";
/* Unpacks the data and the drawing library, resolves roles to colours, draws every figure, and redraws where the theme changes. */
const gcomp = { data: null, drawn: [], redraw: [], pick: null };

gcomp.unpack = async function (id) {
  const node = document.getElementById(id);
  const bytes = Uint8Array.from(atob(node.textContent.trim()), (c) => c.charCodeAt(0));
  node.remove();
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
};

gcomp.colour = function (role) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + role).trim();
};

gcomp.resolved = function (value) {
  if (value === "@sequential") return SEQUENTIAL;
  if (typeof value === "string") return value[0] === "@" ? gcomp.colour(value.slice(1)) : value;
  if (Array.isArray(value)) {
    if (value.length && typeof value[0] !== "object" && !(typeof value[0] === "string" && value[0][0] === "@")) return value;
    return value.map(gcomp.resolved);
  }
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, gcomp.resolved(v)]));
};

gcomp.narrow = () => window.innerWidth < 640;

/* In a narrow window a figure whose axes have one scale, or a round one, needs less height. */
gcomp.height = function (figure) {
  const width = document.getElementById(figure.id).clientWidth;
  if (!gcomp.narrow()) return figure.height;
  if (figure.layout.polar) return Math.min(figure.height, width + 90);
  return figure.shape ? Math.min(figure.height, Math.round((width - 110) * figure.shape) + 120) : figure.height;
};

gcomp.layout = function (own, height, node) {
  const narrow = gcomp.narrow();
  const base = {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", height, width: node.clientWidth,
    font: { family: gcomp.colour("font"), size: narrow ? 11 : 12, color: gcomp.colour("ink") },
    margin: narrow ? { l: 44, r: 8, t: 8, b: 40 } : { l: 60, r: 16, t: 8, b: 46 },
    showlegend: true, legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
    hoverlabel: { bgcolor: gcomp.colour("panel"), bordercolor: gcomp.colour("rule"), font: { color: gcomp.colour("ink") } },
    colorway: ["plus", "minus", "after", "limit", "command", "still"].map(gcomp.colour), hovermode: "closest", dragmode: "zoom",
    modebar: { bgcolor: "rgba(0,0,0,0)", color: gcomp.colour("muted"), activecolor: gcomp.colour("link") },
  };
  const layout = Object.assign(base, gcomp.resolved(own));
  if (narrow && own.legend) layout.legend = base.legend;
  if (narrow && layout.annotations) layout.annotations = layout.annotations.map((a) => Object.assign({}, a, a.brief ? { text: a.brief } : {}));
  return layout;
};

gcomp.config = { displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };

gcomp.draw = function (figure) {
  const node = document.getElementById(figure.id), height = gcomp.height(figure);
  node.style.height = height + "px";
  const layout = gcomp.layout(figure.layout, height, node);
  if (gcomp.narrow() && figure.shape) layout.margin.l = 60;
  if (figure.log !== null) layout.yaxis = Object.assign({}, layout.yaxis, figure.log ? { type: "log", dtick: 1 } : { type: "linear" });
  return Plotly.react(node, gcomp.resolved(figure.data), layout, gcomp.config).then(() => {
    if (node.dataset.ready) return;
    node.dataset.ready = "1";
    node.on("plotly_click", (event) => {
      const line = event.points[0].customdata;
      if (gcomp.pick && line !== undefined) gcomp.pick(line);
    });
  });
};

gcomp.all = function () {
  return Promise.all([...gcomp.data.figures.map(gcomp.draw), ...gcomp.redraw.map((draw) => draw())]);
};

gcomp.themes = function () {
  const button = document.getElementById("theme"), order = ["system", "light", "dark"], root = document.documentElement;
  let at = 0;
  const show = (name) => { if (name === "system") delete root.dataset.theme; else root.dataset.theme = name; gcomp.all(); };
  button.addEventListener("click", () => {
    at = (at + 1) % 3;
    button.textContent = "Theme: " + order[at];
    show(order[at]);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => gcomp.all());
  window.addEventListener("beforeprint", () => { root.dataset.print = "1"; show("light"); });
  window.addEventListener("afterprint", () => { delete root.dataset.print; show(order[at]); });
};

/* The library reads back what it draws of letters in space; the browser asks to be told so beforehand. */
gcomp.canvases = function () {
  const plain = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, more) {
    return plain.call(this, kind, kind === "2d" ? Object.assign({ willReadFrequently: true }, more) : more);
  };
};

gcomp.start = async function () {
  if (typeof DecompressionStream === "undefined") { document.getElementById("old").hidden = false; return; }
  gcomp.canvases();
  gcomp.data = JSON.parse(await gcomp.unpack("data"));
  const script = document.createElement("script");
  script.textContent = await gcomp.unpack("library");
  document.head.append(script);
  for (const button of document.querySelectorAll("button.scale")) {
    button.addEventListener("click", () => {
      const figure = gcomp.data.figures.find((f) => f.id === button.dataset.for);
      figure.log = !figure.log;
      gcomp.draw(figure);
    });
  }
  for (const slider of document.querySelectorAll(".steps input")) {
    slider.addEventListener("input", () => {
      const figure = gcomp.data.figures.find((f) => f.id === slider.dataset.for), steps = figure.steps;
      figure.data = steps.data[Number(slider.value)];
      slider.parentNode.querySelector("output").textContent = steps.values[Number(slider.value)];
      gcomp.draw(figure);
    });
  }
  document.querySelectorAll("button.pick").forEach((b) => b.addEventListener("click", () => gcomp.pick && gcomp.pick(Number(b.dataset.line))));
  if (gcomp.begin) gcomp.begin();
  gcomp.themes();
  let later = 0;
  window.addEventListener("resize", () => {
    clearTimeout(later);
    later = setTimeout(gcomp.all, 100);
  });
  await gcomp.all();
  document.documentElement.dataset.drawn = "1";
};

document.addEventListener("DOMContentLoaded", gcomp.start);
