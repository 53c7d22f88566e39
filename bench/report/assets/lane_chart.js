// Lanes of states over time: ABS phases, valves, switches, frames on the bus.
const LANE_HEIGHT = 15;
const LANE_GAP = 5;

class LaneChart {
  constructor(figure, description, page) {
    this.figure = figure;
    this.description = description;
    this.page = page;
    this.view = page.view;
    this.plot = figure.querySelector(".plot");
    this.names = Object.fromEntries(description.states.map((state) => [state.colour, state.label]));
    const legend = figure.querySelector(".legend");
    for (const state of description.states) legend.append(stateMark(state));
    this.plot.setAttribute("aria-label", `${description.title}. ${description.lanes.map((lane) => `${lane.label} ${lane.note ?? ""}`).join("; ")}`);
    this.layout();
    connectPlot(this, this.view);
    this.view.listen((rangeChanged) => (rangeChanged ? this.draw() : this.drawCursor()));
  }

  layout() {
    this.width = Math.max(240, Math.round(this.plot.clientWidth) || 640);
    const narrow = this.width < 560;
    const { lanes, notes } = this.description;
    this.left = 14 + Math.max(...lanes.map((lane) => textWidth(narrow ? lane.short ?? lane.label : lane.label)));
    this.right = this.width - (narrow || !notes ? 10 : 16 + Math.max(...lanes.map((lane) => textWidth(lane.note ?? ""))));
    this.narrow = narrow;
    this.top = 6;
    this.bottom = this.top + this.description.lanes.length * (LANE_HEIGHT + LANE_GAP);
    this.height = this.bottom + TIME_AXIS_HEIGHT;
    const svg = svgElement("svg", { viewBox: `0 0 ${this.width} ${this.height}`, "aria-hidden": "true" });
    const clip = `clip-${this.figure.id}`;
    this.ground = svgElement("g");
    this.labels = svgElement("g");
    this.marks = svgElement("g", { "clip-path": `url(#${clip})` });
    this.overlay = svgElement("g");
    svg.append(clipPath(clip, this.left, this.right, 0, this.height), this.ground, this.labels, this.marks, this.overlay);
    this.plot.replaceChildren(svg);
    this.draw();
  }

  x(time) { return this.left + ((time - this.view.start) / this.view.span) * (this.right - this.left); }

  draw() {
    drawTimeAxis(this, this.bottom);
    this.labels.replaceChildren();
    this.marks.replaceChildren();
    this.description.lanes.forEach((lane, index) => {
      const y = this.top + index * (LANE_HEIGHT + LANE_GAP);
      const label = this.narrow ? lane.short ?? lane.label : lane.label;
      this.labels.append(svgElement("text", { x: this.left - 8, y: y + 11.5, "text-anchor": "end", class: "lane-label" }, label));
      if (lane.note && !this.narrow && this.description.notes) this.labels.append(svgElement("text", { x: this.right + 8, y: y + 11.5 }, lane.note));
      this.marks.append(svgElement("rect", { x: this.left, y, width: this.right - this.left, height: LANE_HEIGHT, class: "lane-ground" }));
      drawSegments(this, lane.segments, y, LANE_HEIGHT);
      for (const time of lane.events ?? []) {
        if (time < this.view.start || time > this.view.end) continue;
        const x = this.x(time);
        this.marks.append(svgElement("rect", { x: x - 1, y, width: 2, height: LANE_HEIGHT, class: "f-warning" }));
      }
    });
    drawStepLines(this, this.top, this.bottom);
    this.drawCursor();
  }

  drawCursor() {
    this.overlay.replaceChildren();
    drawCursorLine(this, this.top, this.bottom);
    const time = this.view.cursor;
    if (time === null || time < this.view.start || time > this.view.end) return;
    const x = this.x(time);
    const before = x > this.right - 110;
    this.description.lanes.forEach((lane, index) => {
      const segment = lane.segments.find(([from, to]) => time >= from && time < to);
      const text = segment ? segment[3] ?? this.names[segment[2]] : lane.empty;
      if (!text) return;
      const y = this.top + index * (LANE_HEIGHT + LANE_GAP) + 11.5;
      this.overlay.append(svgElement("text", { x: x + (before ? -6 : 6), y, "text-anchor": before ? "end" : "start", class: "halo" }, text));
    });
  }

  showSelection(from, to) { this.selected = from === null ? null : [from, to]; this.drawCursor(); }
}
