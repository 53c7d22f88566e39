// A time chart: curves, ±deviation areas, limit lines, step boundaries and strips of states below the plot.
const TIME_AXIS_HEIGHT = 20;
const STRIP_HEIGHT = 12;

class LineChart {
  constructor(figure, description, page) {
    this.figure = figure;
    this.description = description;
    this.page = page;
    this.view = page.view;
    this.plot = figure.querySelector(".plot");
    this.hidden = new Set();
    this.series = description.series.map((series) => ({ ...series, ...page.signal(series.signal) }));
    this.areas = description.areas.map((area) => ({ ...area, low: page.signal(area.low), high: page.signal(area.high) }));
    this.fullRange = description.range ?? this.rangeOfData();
    this.valueRange = this.fullRange;
    this.decimals = decimalsFor(this.valueRange[1] - this.valueRange[0]);
    this.buildLegend();
    this.describe();
    this.layout();
    connectPlot(this, this.view);
    this.view.listen((rangeChanged) => (rangeChanged ? this.draw() : this.drawCursor()));
  }

  // Range of the values that are in sight; of the whole run where nothing is zoomed, then with limits and zero.
  rangeOfData() {
    const whole = this.view.span > 0.999 * (this.view.full[1] - this.view.full[0]);
    let low = Infinity;
    let high = -Infinity;
    const visit = (value) => { if (value < low) low = value; if (value > high) high = value; };
    this.series.forEach((series, index) => {
      if (this.hidden.has(index)) return;
      const [first, last] = this.visible(series);
      for (let i = first; i <= last; i += 1) visit(series.values[i]);
    });
    if (whole) for (const limit of this.description.limits) visit(limit.value);
    if (!(high >= low)) return this.fullRange ?? [0, 1];
    if (whole && this.description.include_zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
    const smallest = this.description.smallest_span || 1e-6;
    if (low === 0) high = Math.max(high, smallest);
    else if (high - low < smallest) { const centre = (low + high) / 2; low = centre - smallest / 2; high = centre + smallest / 2; }
    const margin = 0.04 * (high - low);
    return [low >= 0 ? Math.max(0, low - margin) : low - margin, high + margin];
  }

  buildLegend() {
    const legend = this.figure.querySelector(".legend");
    this.readouts = this.series.map((series, index) => {
      const button = htmlElement("button");
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      const mark = svgElement("svg", { width: 18, height: 8, "aria-hidden": "true" });
      mark.append(svgElement("path", { d: "M0 4H18", class: this.curveClass(series) }));
      const value = htmlElement("span", "value");
      button.append(mark, htmlElement("span", "text", series.label), value);
      button.addEventListener("click", () => {
        const show = this.hidden.delete(index);
        if (!show) this.hidden.add(index);
        button.setAttribute("aria-pressed", String(show));
        this.draw();
      });
      legend.append(button);
      return value;
    });
    for (const state of this.description.states) legend.append(stateMark(state));
  }

  describe() {
    const parts = this.series.map((series) => {
      const finite = series.values.filter(Number.isFinite);
      if (!finite.length) return `${series.label}: no values`;
      const low = finite.reduce((a, b) => Math.min(a, b));
      const high = finite.reduce((a, b) => Math.max(a, b));
      return `${series.label} ${numberText(low, this.decimals)} to ${numberText(high, this.decimals)} ${this.description.unit}`;
    });
    this.plot.setAttribute("aria-label", `${this.description.title}. ${parts.join("; ")}`);
  }

  curveClass(series) {
    return `curve c-${series.colour} ${series.weight} ${series.dashed ? "dashed" : ""}`;
  }

  layout() {
    this.width = Math.max(240, Math.round(this.plot.clientWidth) || 640);
    this.left = 46;
    this.right = this.width - 10;
    this.top = this.description.step_names ? 20 : 6;
    this.bottom = this.top + this.description.height;
    const strips = this.description.strips.length;
    this.height = this.bottom + TIME_AXIS_HEIGHT + (strips ? strips * (STRIP_HEIGHT + 3) + 2 : 0);
    const svg = svgElement("svg", { viewBox: `0 0 ${this.width} ${this.height}`, "aria-hidden": "true" });
    const [curves, all] = [`curves-${this.figure.id}`, `all-${this.figure.id}`];
    this.ground = svgElement("g");
    this.marks = svgElement("g", { "clip-path": `url(#${all})` });
    this.curves = svgElement("g", { "clip-path": `url(#${curves})` });
    this.overlay = svgElement("g", { "clip-path": `url(#${curves})` });
    svg.append(clipPath(curves, this.left, this.right, this.top - 3, this.bottom + 3), clipPath(all, this.left, this.right, 0, this.height));
    svg.append(this.ground, this.marks, this.curves, this.overlay);
    this.plot.replaceChildren(svg);
    this.draw();
  }

  x(time) { return this.left + ((time - this.view.start) / this.view.span) * (this.right - this.left); }

  y(value) {
    const [low, high] = this.valueRange;
    return this.bottom - ((value - low) / (high - low)) * (this.bottom - this.top);
  }

  draw() {
    this.valueRange = this.description.range ?? this.rangeOfData();
    drawTimeAxis(this, this.bottom + this.stripsHeight());
    this.drawValueAxis();
    this.marks.replaceChildren();
    this.curves.replaceChildren();
    drawStepLines(this, this.top, this.bottom);
    for (const limit of this.description.limits) this.drawLimit(limit);
    for (const area of this.areas) this.drawArea(area);
    this.series.forEach((series, index) => { if (!this.hidden.has(index)) this.drawCurve(series); });
    this.drawStrips();
    this.drawCursor();
  }

  stripsHeight() { return this.description.strips.length ? this.description.strips.length * (STRIP_HEIGHT + 3) + 2 : 0; }

  drawValueAxis() {
    const { ticks, decimals } = ticksBetween(...this.valueRange, this.description.height / 42);
    for (const tick of ticks) {
      const y = Math.round(this.y(tick)) + 0.5;
      this.ground.append(svgElement("line", { x1: this.left, x2: this.right, y1: y, y2: y, class: "grid" }));
      this.ground.append(svgElement("text", { x: this.left - 6, y: y + 3.5, "text-anchor": "end" }, numberText(tick, decimals)));
    }
  }

  drawLimit(limit) {
    const y = this.y(limit.value);
    this.marks.append(svgElement("line", { x1: this.left, x2: this.right, y1: y, y2: y, class: "limit-line" }));
    this.marks.append(svgElement("text", { x: this.left + 4, y: y - 4, class: "limit-text" }, limit.label));
  }

  visible(signal) {
    const first = Math.max(0, firstNotBefore(signal.times, this.view.start) - 1);
    const last = Math.min(signal.times.length - 1, firstNotBefore(signal.times, this.view.end) + 1);
    return [first, last];
  }

  // Points in sight as texts, in stretches without gaps.
  stretches(signal) {
    const [first, last] = this.visible(signal);
    const found = [];
    let stretch = [];
    for (let i = first; i <= last; i += 1) {
      const value = signal.values[i];
      if (Number.isFinite(value)) stretch.push(`${this.x(signal.times[i]).toFixed(1)} ${this.y(value).toFixed(1)}`);
      if (stretch.length && (i === last || !Number.isFinite(value))) { found.push(stretch); stretch = []; }
    }
    return found;
  }

  drawCurve(series) {
    const path = this.stretches(series).map((points) => `M${points.join("L")}`).join("");
    this.curves.append(svgElement("path", { d: path, class: this.curveClass(series), "data-series": series.label }));
  }

  // Both edges of an area have their gaps at the same places.
  drawArea(area) {
    const lower = this.stretches(area.low);
    this.stretches(area.high).forEach((upper, n) => {
      if (!lower[n]) return;
      const outline = `M${upper.join("L")}L${lower[n].reverse().join("L")}Z`;
      this.curves.append(svgElement("path", { d: outline, class: `area f-${area.colour}` }));
    });
  }

  drawStrips() {
    this.description.strips.forEach((strip, index) => {
      const y = this.bottom + 4 + index * (STRIP_HEIGHT + 3);
      this.ground.append(svgElement("text", { x: this.left - 6, y: y + STRIP_HEIGHT - 2, "text-anchor": "end", class: strip.colour ? `f-${strip.colour} strip-label` : "" }, strip.label));
      this.marks.append(svgElement("rect", { x: this.left, y, width: this.right - this.left, height: STRIP_HEIGHT, class: "lane-ground" }));
      drawSegments(this, strip.segments, y, STRIP_HEIGHT);
    });
  }

  drawCursor() {
    const time = this.view.cursor;
    this.overlay.replaceChildren();
    this.series.forEach((series, index) => {
      const value = time === null ? NaN : valueAt(series, time);
      this.readouts[index].textContent = Number.isFinite(value) ? numberText(value, this.decimals) : "";
      if (!Number.isFinite(value) || this.hidden.has(index)) return;
      this.overlay.append(svgElement("circle", { cx: this.x(time), cy: this.y(value), r: 3, class: `f-${series.colour}` }));
    });
    drawCursorLine(this, this.top, this.bottom + this.stripsHeight());
  }

  showSelection(from, to) { this.selected = from === null ? null : [from, to]; this.drawCursor(); }
}

function stateMark(state) {
  const item = htmlElement("span");
  const mark = svgElement("svg", { width: 14, height: 10, "aria-hidden": "true" });
  mark.append(svgElement("rect", { width: 14, height: 10, rx: 2, class: `f-${state.colour}` }));
  item.append(mark, htmlElement("span", "text", state.label));
  return item;
}

function drawTimeAxis(chart, y) {
  const ground = chart.ground;
  ground.replaceChildren();
  const { ticks, decimals } = ticksBetween(chart.view.start, chart.view.end, (chart.right - chart.left) / 80);
  ground.append(svgElement("line", { x1: chart.left, x2: chart.right, y1: y + 0.5, y2: y + 0.5, class: "axis" }));
  ticks.forEach((tick, index) => {
    const x = Math.round(chart.x(tick)) + 0.5;
    ground.append(svgElement("line", { x1: x, x2: x, y1: chart.top, y2: y, class: "grid" }));
    const anchor = x > chart.right - 16 ? "end" : "middle";
    const unit = index === ticks.length - 1 ? " s" : "";
    ground.append(svgElement("text", { x, y: y + 15, "text-anchor": anchor }, numberText(tick, decimals) + unit));
  });
}

function drawStepLines(chart, top, bottom) {
  let free = -Infinity;
  for (const step of chart.page.steps) {
    if (step.start <= chart.view.full[0] || step.start > chart.view.end) continue;
    const x = Math.round(chart.x(step.start)) + 0.5;
    chart.marks.append(svgElement("line", { x1: x, x2: x, y1: top, y2: bottom, class: "step-line" }));
  }
  if (!chart.description.step_names) return;
  for (const step of chart.page.steps) {
    const x = Math.max(chart.x(step.start), chart.left) + 4;
    const end = Math.min(chart.x(step.end), chart.right);
    if (end - x < 8 + textWidth(step.name) || x < free) continue;
    chart.marks.append(svgElement("text", { x, y: top - 7 }, step.name));
    free = x + textWidth(step.name) + 8;
  }
}

function drawSegments(chart, segments, y, height) {
  for (const [from, to, colour, label] of segments) {
    if (to < chart.view.start || from > chart.view.end || colour === "off") continue;
    const x = Math.max(chart.x(from), chart.left - 2);
    const end = Math.min(chart.x(to), chart.right + 2);
    chart.marks.append(svgElement("rect", { x, y, width: Math.max(end - x, 0.6), height, class: `f-${colour}` }));
    const inside = Math.max(x, chart.left) + 4;
    if (label && end - inside > textWidth(label)) {
      chart.marks.append(svgElement("text", { x: inside, y: y + height / 2 + 4, class: "lane-text" }, label));
    }
  }
}

function drawCursorLine(chart, top, bottom) {
  const { view, overlay } = chart;
  if (chart.selected) {
    const [a, b] = chart.selected.map((time) => chart.x(time)).sort((p, q) => p - q);
    overlay.append(svgElement("rect", { x: a, y: top, width: b - a, height: bottom - top, class: "selection" }));
  }
  if (view.cursor === null || view.cursor < view.start || view.cursor > view.end) return;
  const x = chart.x(view.cursor);
  overlay.append(svgElement("line", { x1: x, x2: x, y1: top, y2: bottom, class: "cursor-line" }));
}
