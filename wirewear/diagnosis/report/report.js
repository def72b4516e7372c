"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const by = id => document.getElementById(id), slider = by("cycle");
slider.max = data.cycles.length - 1;
slider.value = slider.max;
const every = k => [...data.measured.flat(), ...data.curves.flatMap(c => c.loops)].flatMap(l => l[k]).filter(Number.isFinite);
const [xs, qs] = [every(0), every(1)];
function showLoop() {
  const k = +slider.value;
  by("at").textContent = figure(data.cycles[k]);
  slider.setAttribute("aria-valuetext", `cycle ${data.cycles[k]}`);
  chart(by("loop"), {x: {label: "displacement δ [µm]", min: 1.06 * Math.min(...xs), max: 1.06 * Math.max(...xs)},
    y: {label: "tangential force Q [N]", min: 1.06 * Math.min(...qs), max: 1.06 * Math.max(...qs)}, zero: true, height: 380,
    series: [...data.measured[k].map(([x, y], r) => ({x, y, color: data.colour, width: 0, marks: true, radius: 2, name: "measured", hidden: r > 0})),
      ...data.curves.map((c, r) => ({x: c.loops[k][0], y: c.loops[k][1], color: c.colour, dash: r ? "6 3" : "", width: 1.8, closed: true, name: c.name, kind: r ? "with" : "now"}))]});
}
slider.addEventListener("input", showLoop);
showLoop();
