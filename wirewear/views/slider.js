"use strict";
/* The slider over the cycles, its button, and the tables to save: what the pages of all runs share. */
const by = id => document.getElementById(id);
const near = (list, cycle, of = c => c) => list.reduce((best, one, k) =>
  Math.abs(Math.log(Math.max(of(one), .5) / cycle)) < Math.abs(Math.log(Math.max(of(list[best]), .5) / cycle)) ? k : best, 0);
const line = (run, x, y, more = {}) => ({x, y, name: run.label, color: run.color, dash: run.dash, ...more});
const CYCLES = {label: "cycles N", log: true, min: 1};

/* Lines of equal tension on a map of displacement and load, each named at its right end. */
const tensions = lines => lines.map(l => {
  const right = l.x.indexOf(Math.max(...l.x)), level = right === 0;
  return {x: l.x, y: l.y, color: "#8a5a00", width: 1, hidden: true, kind: "tension",
    note: {x: l.x[right], y: l.y[right], text: `${figure(l.tension)} MPa`, anchor: level ? "end" : "start", aside: level ? -4 : 5, below: true}};
});

/* Shows every cycle of the list by show(cycle), the last one first. */
function slideOver(cycles, show) {
  const slider = by("cycle");
  slider.max = Math.max(cycles.length - 1, 0);
  slider.value = slider.max;
  const showNow = () => {
    const cycle = cycles[slider.value] ?? 1;
    by("at").textContent = `${figure(cycle)} of ${figure(cycles[cycles.length - 1] ?? 0)}`;
    slider.setAttribute("aria-valuetext", `cycle ${cycle}`);
    show(cycle);
  };
  let playing = 0;
  by("play").addEventListener("click", () => {
    if (playing) { clearInterval(playing); playing = 0; } else playing = setInterval(() => {
      slider.value = +slider.value >= +slider.max ? 0 : +slider.value + 1;
      showNow();
    }, 600);
    by("play").textContent = playing ? "stop" : "play";
    by("play").setAttribute("aria-pressed", String(Boolean(playing)));
  });
  slider.addEventListener("input", showNow);
  addEventListener("resize", showNow);
  return showNow;
}

function showLoops(runs, cycle, unit) {
  const xs = runs.flatMap(r => r.loops.flatMap(l => l.x)), qs = runs.flatMap(r => r.loops.flatMap(l => l.q)), series = [];
  for (const run of runs) {
    if (!run.loops.length) continue;
    const first = run.loops[0], now = run.loops[near(run.loops, cycle, l => l.cycle)];
    if (now !== first) series.push({x: first.x, y: first.q, color: "#c4c4c4", dash: run.dash, width: 1.2, closed: true, name: `cycle ${figure(first.cycle)}`, hidden: run !== runs[0], kind: "first"});
    series.push(line(run, now.x, now.q, {closed: true, kind: "now", width: 2}));
  }
  chart(by("loop"), {x: {label: "displacement δ [µm]", min: 1.08 * Math.min(...xs), max: 1.08 * Math.max(...xs)},
    y: {label: `tangential force Q [${unit}]`, min: 1.08 * Math.min(...qs), max: 1.08 * Math.max(...qs)}, series, zero: true});
  if (runs[0].loops.length) frettingLog(by("log"), runs[0], near(runs[0].loops, cycle, l => l.cycle), unit);
}

/* The columns of all runs, those of each run by of(run), with the run's name before them. */
function joined(runs, of) {
  const columns = {run: []};
  for (const run of runs) {
    const own = of(run), names = Object.keys(own);
    own[names[0]].forEach((_, k) => {
      columns.run.push(`"${run.label.replace(/"/g, '""')}"`);
      for (const name of names) (columns[name] ??= []).push(own[name][k]);
    });
  }
  return columns;
}

function offer(tables) {
  for (const button of document.querySelectorAll("[data-table]")) button.addEventListener("click", () => download(`${button.dataset.table}.csv`, tables[button.dataset.table]()));
}
