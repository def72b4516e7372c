"use strict";
/* Charts as SVG, drawn for the width that they have: chart(element, {x, y, series, ...}). No other file is needed. */
const SVG = "http://www.w3.org/2000/svg";
const THIN = "\u2009", MINUS = "\u2212";

function node(name, attributes, parent, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}

function figure(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-3) {
    const power = Math.floor(Math.log10(size));
    return `${figure(value / 10 ** power, digits)}·10${superscript(power)}`;
  }
  let text = String(Number(value.toPrecision(digits)));
  const [whole, part] = text.split(".");
  text = size >= 1e4 ? whole.replace(/\B(?=(\d{3})+$)/g, THIN) + (part ? "." + part : "") : text;
  return text.replace("-", MINUS);
}

function superscript(power) {
  return String(power).replace(/./g, c => "⁰¹²³⁴⁵⁶⁷⁸⁹"[+c] ?? "⁻");
}

function ticksOf(axis) {
  if (axis.log) {
    const first = Math.ceil(Math.log10(axis.min) - 1e-9), last = Math.floor(Math.log10(axis.max) + 1e-9);
    const every = Math.max(1, Math.ceil((last - first + 1) / 7));
    const found = [];
    for (let power = first; power <= last; power += every) found.push(10 ** power);
    if (found.length > 2) return found;
    const fine = [];
    for (let power = first - 1; power <= last; power++) for (const s of found.length > 1 ? [1, 3] : [1, 2, 3, 5, 7]) fine.push(s * 10 ** power);
    const within = fine.filter(t => t >= axis.min && t <= axis.max);
    if (within.length > 2) return within;
  }
  const raw = (axis.max - axis.min) / (axis.count || 6), decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find(s => s * decade >= raw) * decade;
  const found = [];
  for (let place = Math.ceil(axis.min / step - 1e-9); place * step <= axis.max * (1 + 1e-12) + 1e-9 * step; place++) found.push(place * step);
  return found;
}

function span(axis, values) {
  const known = values.filter(v => Number.isFinite(v) && (!axis.log || v > 0));
  let low = axis.min ?? Math.min(...known), high = axis.max ?? Math.max(...known);
  if (!known.length && axis.min === undefined) { low = axis.log ? 1 : 0; high = axis.log ? 10 : 1; }
  if (axis.log) {
    if (low === high) { low /= 2; high *= 2; }
    const room = axis.tight ? 1 : (high / low) ** 0.03;
    return {...axis, min: axis.min ?? low / room, max: axis.max ?? high * room};
  }
  if (axis.zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
  const least = (axis.least ?? 0.05) * Math.max(Math.abs(low), Math.abs(high)) || 1;
  if (high - low < least) { const middle = (low + high) / 2; low = middle - least / 2; high = middle + least / 2; }
  const room = 0.05 * (high - low);
  return {...axis, min: axis.min ?? low - room, max: axis.max ?? high + room};
}

function placer(axis, from, to) {
  const scale = axis.log ? v => (Math.log(v) - Math.log(axis.min)) / (Math.log(axis.max) - Math.log(axis.min))
    : v => (v - axis.min) / (axis.max - axis.min);
  return v => from + (to - from) * scale(v);
}

function pathOf(xs, ys, closed) {
  let text = "", open = false;
  for (let i = 0; i < xs.length; i++) {
    if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) { open = false; continue; }
    text += `${open ? "L" : "M"}${xs[i].toFixed(1)} ${ys[i].toFixed(1)}`;
    open = true;
  }
  return closed ? text + "Z" : text;
}

const within = (value, axis) => value >= axis.min && value <= axis.max;

/* A point: a circle, a square or a diamond, filled or open. */
function mark(parent, x, y, r, s) {
  const look = s.open ? {fill: "#fff", stroke: s.color, "stroke-width": 1.6} : {fill: s.color, stroke: "#fff", "stroke-width": .8};
  if (s.shape === "square") return node("rect", {x: x - .9 * r, y: y - .9 * r, width: 1.8 * r, height: 1.8 * r, ...look}, parent);
  if (s.shape === "diamond") return node("path", {d: `M${x} ${y - 1.3 * r}L${x + 1.3 * r} ${y}L${x} ${y + 1.3 * r}L${x - 1.3 * r} ${y}Z`, ...look}, parent);
  return node("circle", {cx: x, cy: y, r, ...look}, parent);
}

const drawn = new Map();

/* spec: {x: axis, y: axis, series, height, zero, title}; axis: {label, log, min, max}; a series: {x, y, name, color,
   dash, width, marks, shape, open, fill, closed, hidden, note}. Drawn again when the width changes or by calling it once more. */
function chart(element, spec) {
  drawn.set(element, spec);
  const width = Math.max(element.clientWidth, 200), height = Math.round(spec.height ?? Math.min(0.68 * width, 330));
  const values = key => spec.series.flatMap(s => s[key] ?? []);
  const x = span(spec.x, values("x")), y = span(spec.y, values("y"));
  const marks = ticksOf({...y, count: height / 52});
  const left = 32 + Math.max(...marks.map(t => figure(t).length), 1) * 7.4, right = width - 16, top = 10, bottom = height - 42;
  const atX = placer(x, left, right), atY = placer(y, bottom, top);
  element.classList.add("chart");
  const picture = node("svg", {viewBox: `0 0 ${width} ${height}`, height, role: "img", "aria-label": spec.title ?? `${y.label} against ${x.label}`});
  for (const tick of ticksOf({...x, count: width / 75})) {
    const at = atX(tick);
    node("line", {x1: at, x2: at, y1: top, y2: bottom, class: "grid"}, picture);
    node("line", {x1: at, x2: at, y1: bottom, y2: bottom + 4, class: "axis"}, picture);
    const text = figure(tick), half = 3.8 * text.length;
    node("text", {x: Math.min(at, width - half - 1), y: bottom + 17, "text-anchor": "middle"}, picture, text);
  }
  for (const tick of marks) {
    const at = atY(tick);
    node("line", {x1: left, x2: right, y1: at, y2: at, class: "grid"}, picture);
    node("line", {x1: left - 4, x2: left, y1: at, y2: at, class: "axis"}, picture);
    node("text", {x: left - 7, y: at + 4, "text-anchor": "end"}, picture, figure(tick));
  }
  if (spec.zero) {
    if (x.min < 0 && x.max > 0) node("line", {x1: atX(0), x2: atX(0), y1: top, y2: bottom, class: "zero"}, picture);
    if (y.min < 0 && y.max > 0) node("line", {x1: left, x2: right, y1: atY(0), y2: atY(0), class: "zero"}, picture);
  }
  const inside = node("clipPath", {id: `clip-${element.id}`}, picture);
  node("rect", {x: left, y: top - 4, width: right - left + 6, height: bottom - top + 8}, inside);
  const area = node("g", {"clip-path": `url(#clip-${element.id})`}, picture);
  for (const s of spec.series) {
    const xs = s.x.map(atX), ys = s.y.map(v => y.log && !(v > 0) ? NaN : atY(v));
    if (s.fill) node("path", {d: pathOf(xs, ys, true), fill: s.fill, stroke: "none"}, area);
    if (s.color && s.width !== 0) node("path", {d: pathOf(xs, ys, s.closed), fill: "none", stroke: s.color, "stroke-width": s.width ?? 1.8,
      "stroke-dasharray": s.dash ?? "", "stroke-linejoin": "round", class: s.kind ?? "curve"}, area);
    if (s.marks) xs.forEach((at, i) => {
      if (!Number.isFinite(ys[i])) return;
      const dot = mark(area, at, ys[i], s.radius ?? 3.2, s);
      node("title", {}, dot, `${s.name ? s.name + ": " : ""}${figure(s.x[i])}, ${figure(s.y[i])}`);
    });
    if (s.note && within(s.note.x, x) && within(s.note.y, y)) {
      const at = atY(s.note.y);
      node("text", {x: atX(s.note.x) + (s.note.aside ?? 0), y: s.note.below || at < top + 18 ? at + 14 : at - 8, "text-anchor": s.note.anchor ?? "middle"}, picture, s.note.text);
    }
  }
  node("path", {d: `M${left} ${top}V${bottom}H${right}`, class: "axis"}, picture);
  node("text", {x: (left + right) / 2, y: height - 6, "text-anchor": "middle"}, picture, x.label);
  node("text", {transform: `translate(12 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle"}, picture, y.label);
  element.replaceChildren(legend(spec.series.filter(s => s.name && !s.hidden)), picture);
}

function legend(series) {
  const box = document.createElement("div");
  box.className = "legend";
  if (series.length < 2) return box;
  for (const s of series) {
    const entry = document.createElement("span"), key = node("svg", {viewBox: "0 0 26 10"});
    if (s.width !== 0) node("line", {x1: 0, x2: 26, y1: 5, y2: 5, stroke: s.color ?? s.fill, "stroke-width": Math.min(s.width ?? 1.8, 4), "stroke-dasharray": s.dash ?? ""}, key);
    if (s.marks) mark(key, 13, 5, 3.2, s);
    entry.append(key, s.name);
    box.append(entry);
  }
  return box;
}

function download(name, columns) {
  const names = Object.keys(columns), rows = columns[names[0]].map((_, i) => names.map(n => columns[n][i] ?? "").join(","));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([[names.join(","), ...rows, ""].join("\n")], {type: "text/csv"}));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

let resized = 0;
addEventListener("resize", () => {
  cancelAnimationFrame(resized);
  resized = requestAnimationFrame(() => drawn.forEach((spec, element) => chart(element, spec)));
});
