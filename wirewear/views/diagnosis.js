"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const by = id => document.getElementById(id), slider = by("cycle");
if (slider) {
  slider.max = data.cycles.length - 1;
  slider.value = data.begin;
}
const every = k => [...data.measured.flat(), ...data.curves.flatMap(c => c.loops)].flatMap(l => l[k]).filter(Number.isFinite);
const [xs, qs] = [every(0), every(1)];
function showLoop() {
  const k = +slider.value;
  by("at").textContent = figure(data.cycles[k]);
  slider.setAttribute("aria-valuetext", `cycle ${data.cycles[k]}`);
  chart(by("loop"), {x: {label: "displacement δ [µm]", min: 1.06 * Math.min(...xs), max: 1.06 * Math.max(...xs)},
    y: {label: "tangential force Q [N]", min: 1.06 * Math.min(...qs), max: 1.06 * Math.max(...qs)}, zero: true, height: 260,
    series: [...data.measured[k].map(([x, y], r) => ({x, y, color: data.colour, width: 0, marks: true, radius: 2, name: "measured", hidden: r > 0})),
      ...data.curves.map((c, r) => ({x: c.loops[k][0], y: c.loops[k][1], color: c.colour, dash: r ? "6 3" : "", width: 1.8, closed: true, name: c.name, kind: r ? "with" : "now"}))]});
}
const lefts = data.left.flat(2).flatMap(([, left, band]) => [...left, ...band]).filter(Number.isFinite).map(Math.abs);
const most = 1.06 * Math.max(...lefts);
function showLeft() {
  const k = +slider.value, series = [];
  for (const [x, , band] of data.left[data.left.length - 1][k]) {
    series.push({x: [...x, ...[...x].reverse()], y: [...band, ...[...band].reverse().map(b => b === null ? null : -b)], fill: "#00000014", name: "95 % of tests", width: 5, hidden: series.length > 0});
  }
  data.left.forEach((cycles, c) => cycles[k].forEach(([x, left], branch) => series.push({x, y: left, color: data.curves[c].colour,
    dash: branch ? "5 3" : "", width: 1.8, name: `measured less model${c ? " " + data.curves[c].name : ""}`, hidden: branch > 0, kind: "left"})));
  chart(by("left"), {x: {label: "displacement δ [µm]", min: 1.06 * Math.min(...xs), max: 1.06 * Math.max(...xs)},
    y: {label: "ΔQ [N]", min: -most, max: most}, zero: true, height: 240, series});
}
data.sections.forEach((wire, place) => chart(by(`section${place}`), {x: {label: "along the motion x [µm]"}, y: {label: "height [µm]"}, zero: true, height: 250,
  series: [...wire.measured.map(([x, y], test) => ({x, y, color: data.colour, width: 1.4, name: "measured", hidden: test > 0})),
    ...wire.bowls.map(([x, y], c) => ({x, y, color: data.curves[c].colour, dash: c ? "6 3" : "", width: 1.8, name: data.curves[c].name, kind: "bowl"}))]}));
for (const folded of document.querySelectorAll("details")) folded.addEventListener("toggle", () => dispatchEvent(new Event("resize")));
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(folded => { folded.open = true; }));
function show() { showLoop(); showLeft(); }
if (slider) {
  slider.addEventListener("input", show);
  show();
}
