"use strict";
const data = JSON.parse(by("data").textContent);
const DELTA = {label: "displacement amplitude δa [µm]", log: true, min: data.reach[0], max: data.reach[1]};
const LOAD = {label: `normal load P [N${data.per}]`, log: true, min: data.loads[0], max: data.loads[1]};

/* Every test as a mark of its regime, numbered, and a key for each regime. */
const marked = (x, y, more = () => ({})) => [
  ...data.tests.map(t => ({x: [].concat(x(t)), y: [].concat(y(t)), ...data.regimes[t.regime], width: 0, marks: true, radius: 4.5, name: t.name, hidden: true, ...more(t)})),
  ...Object.entries(data.regimes).filter(([name]) => data.tests.some(t => t.regime === name)).map(([name, look]) => ({x: [], y: [], ...look, width: 0, marks: true, name}))];
const numbered = t => ({note: {x: t.amplitude, y: t.load, text: t.label}});
const slides = (named = true) => data.contacts.flatMap((c, k) => [
  {x: c.test, y: c.load, color: "#1a1a1a", dash: ["", "8 2 2 2", "10 3", "2 2"][k % 4], width: 1.6, name: c.label, hidden: !named},
  {x: c.contact, y: c.load, color: "#1a1a1a", dash: "5 3", width: .9, hidden: true}]);

chart(by("conditions"), {x: DELTA, y: LOAD, series: [...slides(), ...marked(t => t.amplitude, t => t.load, numbered)]});
chart(by("response"), {x: DELTA, y: LOAD, series: [...tensions(data.contacts.flatMap(c => c.tensions)), ...slides(false),
  ...marked(t => t.amplitude, t => t.load, t => ({open: t.cracks === "found", ...numbered(t)}))]});
const end = Math.max(...data.tests.flatMap(t => t.energy), 0);
chart(by("volume"), {x: {label: `friction energy ΣE [J${data.per}]`, zero: true}, y: {label: `worn volume V [10⁻³ mm³${data.per}]`, zero: true}, series: [
  ...data.lines.map((l, k) => ({x: [Math.max(l.threshold, 0), end], y: [l.slope * Math.max(-l.threshold, 0), l.slope * (end - l.threshold)], color: "#1a1a1a", width: 1.2, dash: k ? "5 3" : "", hidden: true})),
  ...marked(t => t.energy, t => t.volume)]});
for (const [place, key, label, at] of [["ratio", "energy_ratio", "energy ratio A", .2], ["free", "system_free_ratio", "system-free ratio B", .77]]) {
  const last = Math.max(...data.tests.flatMap(t => t.cycles), 10);
  chart(by(place), {x: CYCLES, y: {label, min: 0, max: 1.1}, series: [
    {x: [1, last], y: [at, at], color: "#8a8a8a", dash: "4 3", width: 1.2, name: "transition"},
    ...marked(t => t.cycles, t => t[key], () => ({width: 1, radius: 3}))]});
}
