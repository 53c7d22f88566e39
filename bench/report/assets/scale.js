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

function decodeSeries(signal) {
  const { start, step } = signal;
  const values = new Float32Array(decodeBytes(signal.data).buffer);
  const offsets = signal.offsets ? decodeBytes(signal.offsets) : null;
  const times = Float64Array.from(values, (_, k) => start + step * (offsets ? 2 * ((k >> 1) + offsets[k] / 255) : k));
  return { start, step, values, times };
}

// Value of the point that is nearest to a time, NaN outside the signal.
function valueAt(signal, time) {
  const near = Math.round((time - signal.start) / signal.step);
  let best = NaN;
  let distance = 3 * signal.step;
  for (let k = Math.max(0, near - 2); k <= Math.min(signal.values.length - 1, near + 2); k += 1) {
    const away = Math.abs(signal.times[k] - time);
    if (away < distance) { distance = away; best = signal.values[k]; }
  }
  return best;
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
