// Small helpers: SVG elements, axis ticks, numbers as text, decoding of inline data.
const SVG_NAMESPACE = "http://www.w3.org/2000/svg";

function svgElement(tag, attributes = {}, text = null) {
  const element = document.createElementNS(SVG_NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== null) element.textContent = text;
  return element;
}

function htmlElement(tag, className = "", text = null) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text !== null) element.textContent = text;
  return element;
}

const measuring = document.createElement("canvas").getContext("2d");

// Width of a chart's text in pixels, in the font that the style gives it.
function textWidth(text) {
  measuring.font = '11.5px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  return measuring.measureText(text).width;
}

// A clip path for everything that must stay inside the plot.
function clipPath(id, left, right, top, bottom) {
  const clip = svgElement("clipPath", { id });
  clip.append(svgElement("rect", { x: left, y: top, width: right - left, height: bottom - top }));
  return clip;
}

function decodeBytes(text) {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
}

// Points of a signal from its pieces: times that never fall, and values.
function decodeSeries(pieces) {
  const times = [];
  const values = [];
  for (const { start, step, data, offsets } of pieces) {
    const places = offsets ? decodeBytes(offsets) : null;
    new Float32Array(decodeBytes(data).buffer).forEach((value, k) => {
      times.push(start + step * (places ? 2 * ((k >> 1) + places[k] / 255) : k));
      values.push(value);
    });
  }
  return { times: Float64Array.from(times), values: Float32Array.from(values) };
}

// Index of the first point that is not before a time.
function firstNotBefore(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle + 1; else high = middle;
  }
  return low;
}

// Value of the point that is nearest to a time, NaN outside the signal.
function valueAt(signal, time) {
  const { times, values } = signal;
  const after = firstNotBefore(times, time);
  if (after === times.length) return time - times[after - 1] < 0.05 ? values[after - 1] : NaN;
  if (after === 0) return times[0] - time < 0.05 ? values[0] : NaN;
  return time - times[after - 1] < times[after] - time ? values[after - 1] : values[after];
}

function niceStep(span, wanted) {
  const rough = span / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(rough));
  const lead = rough / power;
  return (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 2.5 ? 2.5 : lead <= 5 ? 5 : 10) * power;
}

function ticksBetween(low, high, wanted) {
  const step = niceStep(high - low, wanted);
  const ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i += 1) ticks.push(i * step);
  return { ticks, decimals: Math.min(6, Math.max(0, -Math.floor(Math.log10(step) + 1e-9) + (lastDigitIsHalf(step) ? 1 : 0))) };
}

function lastDigitIsHalf(step) {
  const lead = step / 10 ** Math.floor(Math.log10(step) + 1e-9);
  return Math.abs(lead - 2.5) < 1e-6;
}

function numberText(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? (0).toFixed(decimals) : text).replace("-", "−");
}

// Decimals that show a thousandth of the range.
function decimalsFor(range) {
  if (!(range > 0)) return 1;
  return Math.min(4, Math.max(0, 2 - Math.floor(Math.log10(range))));
}
