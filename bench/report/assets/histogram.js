// Histogram with logarithmic axes: the rare late tick must stay visible beside ten thousand punctual ones.
class Histogram {
  constructor(figure, description) {
    this.description = description;
    this.plot = figure.querySelector(".plot");
    this.plot.setAttribute("aria-label", `${description.title}. ${description.markers.map((marker) => `${marker.label} ${marker.text}`).join("; ")}`);
    this.layout();
  }

  layout() {
    const { edges, counts, markers, unit, height } = this.description;
    const width = Math.max(240, Math.round(this.plot.clientWidth) || 640);
    const [left, right, top] = [46, width - 12, 8];
    const bottom = top + height;
    const [low, high] = [Math.log10(edges[0]), Math.log10(edges[edges.length - 1])];
    const tallest = Math.max(1, ...counts);
    const decades = Math.max(1, Math.ceil(Math.log10(tallest)));
    const x = (value) => left + ((Math.log10(value) - low) / (high - low)) * (right - left);
    const y = (count) => bottom - (count > 0 ? (Math.log10(count) + 0.25) / (decades + 0.25) : 0) * (bottom - top);
    const svg = svgElement("svg", { viewBox: `0 0 ${width} ${bottom + TIME_AXIS_HEIGHT}`, "aria-hidden": "true" });
    for (let power = 0; power <= decades; power += 1) {
      const level = Math.round(y(10 ** power)) + 0.5;
      svg.append(svgElement("line", { x1: left, x2: right, y1: level, y2: level, class: "grid" }));
      svg.append(svgElement("text", { x: left - 6, y: level + 4, "text-anchor": "end" }, (10 ** power).toLocaleString("en")));
    }
    counts.forEach((count, i) => {
      if (!count) return;
      const [from, to] = [x(edges[i]), x(edges[i + 1])];
      svg.append(svgElement("path", { d: `M${from.toFixed(1)} ${bottom}V${y(count).toFixed(1)}H${Math.max(to - 0.8, from + 0.6).toFixed(1)}V${bottom}Z`, class: "f-bench" }));
    });
    svg.append(svgElement("line", { x1: left, x2: right, y1: bottom + 0.5, y2: bottom + 0.5, class: "axis" }));
    for (let power = Math.ceil(low - 1e-9); power <= high + 1e-9; power += 1) {
      const anchor = power >= high - 1e-9 ? "end" : "middle";
      const text = unit === "µs" && power >= 3 ? `${10 ** (power - 3)} ms` : `${numberText(10 ** power, Math.max(0, -power))} ${unit}`;
      svg.append(svgElement("text", { x: x(10 ** power), y: bottom + 15, "text-anchor": anchor }, text));
    }
    this.drawMarkers(svg, markers, x, top, bottom, right);
    this.plot.replaceChildren(svg);
  }

  drawMarkers(svg, markers, x, top, bottom, right) {
    for (const marker of markers) {
      const at = x(marker.value);
      svg.append(svgElement("line", { x1: at, x2: at, y1: top, y2: bottom, class: marker.limit ? "limit-line" : "step-line" }));
      if (!marker.limit) continue;
      const text = `${marker.label} ${marker.text}`;
      const side = at + textWidth(text) + 6 > right ? "end" : "start";
      svg.append(svgElement("text", { x: at + (side === "end" ? -5 : 5), y: top + 4, "text-anchor": side, class: "limit-text" }, text));
    }
  }
}
