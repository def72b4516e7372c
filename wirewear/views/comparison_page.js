"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const by = id => document.getElementById(id);
const SIMULATED = "#0072B2", MEASURED = "#8a8a8a", slider = by("cycle");
slider.max = data.loops.length - 1;
slider.value = slider.max;

const measured = (tests, more = {}) => tests.map(([x, y], k) => ({x, y, color: MEASURED, width: 1.2, name: "measured", hidden: k > 0, ...more}));
const simulated = ([x, y], more = {}) => ({x, y, color: SIMULATED, width: 2, name: "simulated", ...more});
const every = k => data.loops.flatMap(l => [...l.simulated[k], ...l.measured.flatMap(m => m[k])]).filter(Number.isFinite);
const [xs, qs] = [every(0), every(1)];

function showLoop() {
  const loop = data.loops[slider.value];
  by("at").textContent = figure(loop.cycle);
  slider.setAttribute("aria-valuetext", `cycle ${loop.cycle}`);
  chart(by("loop"), {x: {label: "displacement δ [µm]", min: 1.06 * Math.min(...xs), max: 1.06 * Math.max(...xs)},
    y: {label: "tangential force Q [N]", min: 1.06 * Math.min(...qs), max: 1.06 * Math.max(...qs)}, zero: true,
    series: [...measured(loop.measured, {closed: true}), simulated(loop.simulated, {closed: true, kind: "now"})]});
}

for (const [name, {label, simulated: own, measured: tests}] of Object.entries(data.evolution))
  chart(by(name), {x: {label: "cycles N", log: true, min: 1}, y: {label}, series: [
    ...measured(tests, {marks: tests.some(([x]) => x.length < 40), radius: 2.6}), simulated(own)]});
const dashes = ["", "6 3", "2 2"];
chart(by("friction"), {x: {label: "cycles N", log: true, min: 1}, y: {label: "coefficient of friction µ", least: .1}, series:
  Object.values(data.friction).flatMap(({label, simulated: own, measured: tests}, k) => [
    ...tests.map(([x, y]) => ({x, y, color: MEASURED, width: 1, dash: dashes[k], hidden: true, marks: true, radius: 2.2})),
    simulated(own, {dash: dashes[k], name: label})])});
const cards = by("sections");
for (const {wire, sections} of data.scars) for (const [k, {title: words, label, at, simulated: own, measured: tests}] of sections.entries()) {
  const card = document.createElement("section"), title = document.createElement("h3"), place = document.createElement("div");
  title.textContent = words;
  place.id = `section-${wire}-${k}`;
  card.append(title, place);
  cards.append(card);
  chart(place, {x: {label}, y: {label: "height against unworn [µm]"}, series: [
    ...measured(tests.map(depth => [at, depth.map(d => d === null ? NaN : -d)])), simulated([at, own.map(d => d === null ? NaN : -d)])]});
}
slider.addEventListener("input", showLoop);
if (data.loops.length) showLoop();
