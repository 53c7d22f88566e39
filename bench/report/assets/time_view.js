// The time range and the cursor that all charts share. A change redraws once per animation frame.
class TimeView {
  constructor(full, shown) {
    this.full = full;
    [this.start, this.end] = shown;
    this.cursor = null;
    this.listeners = [];
    this.pending = false;
    this.rangeChanged = false;
  }

  listen(listener) { this.listeners.push(listener); }

  get span() { return this.end - this.start; }

  setRange(start, end) {
    const [first, last] = this.full;
    const smallest = (last - first) / 2000;
    let span = Math.min(Math.max(end - start, smallest), last - first);
    let from = Math.min(Math.max(start, first), last - span);
    this.start = from;
    this.end = from + span;
    this.rangeChanged = true;
    this.notify();
  }

  reset() { this.setRange(...this.full); }

  zoom(factor, around = null) {
    const centre = around ?? (this.cursor !== null && this.cursor > this.start && this.cursor < this.end ? this.cursor : (this.start + this.end) / 2);
    this.setRange(centre - (centre - this.start) * factor, centre + (this.end - centre) * factor);
  }

  pan(share) { this.setRange(this.start + share * this.span, this.end + share * this.span); }

  setCursor(time) {
    this.cursor = time === null ? null : Math.min(Math.max(time, this.full[0]), this.full[1]);
    this.notify();
  }

  moveCursor(share) {
    const time = (this.cursor ?? this.start) + share * this.span;
    this.setCursor(time);
    if (this.cursor < this.start || this.cursor > this.end) this.setRange(this.cursor - this.span / 2, this.cursor + this.span / 2);
  }

  show(time) {
    const half = Math.min(0.5, (this.full[1] - this.full[0]) / 2);
    this.setRange(time - half, time + half);
    this.setCursor(time);
  }

  notify() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      const changed = this.rangeChanged;
      this.rangeChanged = false;
      for (const listener of this.listeners) listener(changed);
    });
  }
}

// Pointer and keys of a plot: hover or tap moves the cursor, drag zooms, double click shows everything.
function connectPlot(chart, view) {
  const plot = chart.plot;
  let dragFrom = null;
  const timeAt = (event) => {
    const box = plot.getBoundingClientRect();
    const share = ((event.clientX - box.left) * (chart.width / box.width) - chart.left) / (chart.right - chart.left);
    return view.start + Math.min(Math.max(share, 0), 1) * view.span;
  };
  plot.addEventListener("pointermove", (event) => {
    const time = timeAt(event);
    view.setCursor(time);
    if (dragFrom !== null) chart.showSelection(dragFrom, time);
  });
  plot.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse" && dragFrom === null) view.setCursor(null); });
  plot.addEventListener("pointerdown", (event) => {
    view.setCursor(timeAt(event));
    if (event.pointerType !== "mouse" || event.button !== 0) return;
    dragFrom = timeAt(event);
    plot.setPointerCapture(event.pointerId);
  });
  const finish = (event) => {
    if (dragFrom === null) return;
    const [from, to] = [dragFrom, timeAt(event)].sort((a, b) => a - b);
    dragFrom = null;
    chart.showSelection(null, null);
    if (event.type === "pointerup" && to - from > 0.01 * view.span) view.setRange(from, to);
  };
  plot.addEventListener("pointerup", finish);
  plot.addEventListener("pointercancel", finish);
  plot.addEventListener("dblclick", () => view.reset());
  plot.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    view.zoom(event.deltaY > 0 ? 1.25 : 0.8, timeAt(event));
  }, { passive: false });
  plot.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? 0.1 : 0.01;
    const actions = {
      ArrowLeft: () => view.moveCursor(-step), ArrowRight: () => view.moveCursor(step),
      "+": () => view.zoom(0.5), "=": () => view.zoom(0.5), "-": () => view.zoom(2),
      PageUp: () => view.pan(-0.5), PageDown: () => view.pan(0.5), Home: () => view.reset(), Escape: () => view.setCursor(null),
    };
    if (!actions[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    actions[event.key]();
  });
}
