// Start: decode the inline data, build every chart, connect the toolbar and the links to instants.
const content = JSON.parse(document.getElementById("data").textContent);
const decoded = new Map();
const page = {
  view: new TimeView(content.span, content.focus),
  steps: content.steps,
  signal(name) {
    if (!decoded.has(name)) decoded.set(name, decodeSeries(content.signals[name]));
    return decoded.get(name);
  },
};
const kinds = { lines: LineChart, lanes: LaneChart, histogram: Histogram };
const charts = content.charts.map((description) => new kinds[description.kind](document.getElementById(`chart-${description.id}`), description, page));

function connectToolbar() {
  const toolbar = document.querySelector(".toolbar");
  if (!toolbar) return;
  const buttons = [...toolbar.querySelectorAll("[data-start]")];
  const output = toolbar.querySelector("output");
  for (const button of buttons) button.addEventListener("click", () => page.view.setRange(Number(button.dataset.start), Number(button.dataset.end)));
  toolbar.querySelector("[data-zoom=in]").addEventListener("click", () => page.view.zoom(0.5));
  toolbar.querySelector("[data-zoom=out]").addEventListener("click", () => page.view.zoom(2));
  const show = () => {
    const { view } = page;
    const decimals = view.span < 1 ? 3 : 2;
    output.textContent = view.cursor === null ? `${numberText(view.start, decimals)} to ${numberText(view.end, decimals)} s` : `t = ${numberText(view.cursor, 3)} s`;
    for (const button of buttons) {
      const same = Math.abs(Number(button.dataset.start) - view.start) + Math.abs(Number(button.dataset.end) - view.end) < 1e-3 * (view.full[1] - view.full[0]);
      button.setAttribute("aria-pressed", String(same));
    }
  };
  page.view.listen(show);
  show();
}

function showInstant(time, chart) {
  page.view.show(time);
  const target = chart ? document.getElementById(`chart-${chart}`) : null;
  (target ?? document.getElementById("signals")).scrollIntoView({ block: "start" });
}

connectToolbar();
for (const button of document.querySelectorAll("[data-at]")) {
  button.addEventListener("click", () => showInstant(Number(button.dataset.at), button.dataset.chart));
}
const wanted = /^#t=([-\d.]+)$/.exec(location.hash);
if (wanted && content.charts.length) showInstant(Number(wanted[1]), null);

let layoutWidth = document.documentElement.clientWidth;
new ResizeObserver(() => {
  const width = document.documentElement.clientWidth;
  if (width === layoutWidth) return;
  layoutWidth = width;
  for (const chart of charts) chart.layout();
}).observe(document.documentElement);
addEventListener("beforeprint", () => { for (const details of document.querySelectorAll("details")) details.open = true; });
document.documentElement.dataset.ready = "true";
