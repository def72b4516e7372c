"use strict";
const data = JSON.parse(by("data").textContent), runs = data.runs;
const cycles = [...new Set(runs.flatMap(r => r.loops.map(l => l.cycle)))].sort((a, b) => a - b);
const scarRuns = runs.filter(r => r.scars);
const each = (y, make) => ({x: CYCLES, y, series: runs.flatMap(make)});
const column = (name, label, more = {}) => each({label, ...more}, r => line(r, r.evolution.cycle, r.evolution[name], {marks: r.evolution.cycle.length < 30}));

function showWords(cycle) {
  by("loop-words").textContent = runs.map(r => {
    const k = near(r.evolution.cycle, cycle), e = r.evolution;
    return `${runs.length > 1 ? r.label + ": " : ""}slip δ0 ${figure(e.slip_amplitude_um[k], 3)} µm, energy ${figure(e.dissipated_energy_mJ[k], 3)} mJ, largest Q ${figure(e.max_tangential_force_N[k], 3)} N, energy ratio ${figure(e.energy_ratio[k], 2)}`;
  }).join("; ") + ".";
}

/* Depths as they are packed: shares of the deepest in little-endian 16-bit integers. */
function unpacked(scar, k) {
  if (!scar.fields) scar.fields = [];
  if (!scar.fields[k]) {
    const bytes = Uint8Array.from(atob(scar.depths[k]), c => c.charCodeAt(0)), view = new DataView(bytes.buffer), n = scar.lines.length;
    scar.fields[k] = scar.lines.map((_, i) => scar.lines.map((_, j) => view.getUint16(2 * (i * n + j), true) / 65535 * scar.deepest));
  }
  return scar.fields[k];
}

const surface = scarRuns.length ? new Surface(by("scar"), data.shades) : null;
const choices = scarRuns.flatMap((r, i) => Object.keys(r.scars).map(b => [i, b]));
for (const [i, body] of choices) by("which").add(new Option(`${scarRuns.length > 1 ? scarRuns[i].label + ", " : ""}${scarRuns[i].scars[body].called}`, `${i} ${body}`));
function showScar(cycle) {
  if (!surface) { by("scar-card").hidden = by("section-card").hidden = true; return; }
  const [i, body] = by("which").value.split(" "), scar = scarRuns[i].scars[body], k = near(scar.cycles, cycle), depth = unpacked(scar, k);
  const steep = by("steep").checked ? 4 : 1;
  const z = scar.unworn.map((row, a) => row.map((h, b) => h === null ? null : h / steep - depth[a][b]));
  surface.show({x: scar.lines, y: scar.lines, z, depth, deepest: scar.deepest, exaggeration: steep});
  by("scale").textContent = `Cycle ${figure(scar.cycles[k])}: ${figure(Math.max(...depth.map(r => Math.max(...r))), 3)} µm deep; dark is ${figure(scar.deepest, 3)} µm.`;
  const shown = scarRuns.map(r => [r, r.scars[body]]), own = shown[0][1].section, heights = shown.flatMap(([, s]) => s.section.unworn.map((h, a) => h - s.section.depths[s.cycles.length - 1][a]));
  const low = 1.5 * Math.min(...shown.map(([, s]) => -s.deepest + Math.min(0, ...s.section.unworn.filter((h, a) => s.section.depths[s.cycles.length - 1][a] > 0))), -1e-3);
  chart(by("section"), {x: {label: "position along the motion x [µm]"}, y: {label: `height z, ${scar.called} [µm]`, min: Math.max(low, Math.min(...heights)), max: -0.12 * low}, series: [
    {x: own.x, y: own.unworn, color: "#8a8a8a", dash: "4 3", width: 1.2, name: "unworn"},
    ...shown.map(([r, s]) => line(r, s.section.x, s.section.unworn.map((h, a) => h - s.section.depths[near(s.cycles, cycle)][a]), {kind: "worn"}))]});
}

function showAll(cycle) {
  showLoops(runs, cycle, "N");
  showWords(cycle);
  showScar(cycle);
}

function showCourse() {
  chart(by("amplitudes"), {x: CYCLES, y: {label: "amplitude [µm]"}, series: [
    {x: runs[0].evolution.cycle, y: runs[0].evolution.displacement_amplitude_um, color: "#1a1a1a", width: 1.2, name: "displacement δa"},
    ...runs.map(r => line(r, r.evolution.cycle, r.evolution.slip_amplitude_um, {name: `slip δ0${runs.length > 1 ? ", " + r.label : ""}`, marks: r.evolution.cycle.length < 30}))]});
  chart(by("friction"), {x: CYCLES, y: {label: "coefficient of friction µ", least: .2}, series: runs.flatMap(r => [
    line(r, r.friction.cycle, r.friction.friction_max, {marks: true, dash: ""}),
    line(r, r.friction.cycle, r.friction.friction_energy, {dash: "", width: 1, hidden: true}),
    line(r, r.friction.cycle, r.friction.friction_geometry_independent, {dash: "5 3", width: 1.4, hidden: true})])});
  chart(by("energy"), column("dissipated_energy_mJ", "energy per cycle [mJ]"));
  chart(by("depth"), {x: CYCLES, y: {label: "depth [µm]", log: true}, series: runs.flatMap(r => r.bodies.map(([body, called], k) =>
    line(r, r.evolution.cycle, r.evolution[`max_depth_${body}_um`], {dash: ["", "5 3"][k], name: `${runs.length > 1 ? r.label + ", " : ""}${called}`})))});
  chart(by("volume"), {x: {label: "friction energy ΣE [J]", zero: true}, y: {label: "worn volume V [10⁻³ mm³]", zero: true}, series: runs.flatMap(r => {
    const e = r.evolution, end = Math.max(...e.accumulated_energy_J);
    return [line(r, e.accumulated_energy_J, e.cycle.map((_, k) => 1e3 * r.bodies.reduce((sum, [body]) => sum + e[`worn_volume_${body}_mm3`][k], 0)), {marks: true, width: 0}),
      line(r, [0, end], [0, 1e3 * (r.slope_mm3_per_J ?? 0) * end], {hidden: true, width: 1.2, dash: ""})];
  })});
  by("slope").textContent = runs.map(r => `${runs.length > 1 ? r.label + ": s" : "S"}lope ${figure(r.slope_mm3_per_J, 3)} mm³/J`).join("; ") + ", of the line through the origin.";
  chart(by("pressure"), {x: CYCLES, y: {label: "pressure [MPa]", log: true}, series: runs.flatMap(r => r.pressures.map(([name, words, dash]) =>
    line(r, r.evolution.cycle, r.evolution[name], {dash, name: [runs.length > 1 ? r.label : "", words].filter(Boolean).join(", "), marks: r.evolution.cycle.length < 30})))});
  chart(by("ratio"), {x: CYCLES, y: {label: "energy ratio A", min: 0, max: 1}, series: [
    {x: [cycles[0] ?? 1, cycles[cycles.length - 1] ?? 10], y: [.2, .2], color: "#8a8a8a", dash: "4 3", width: 1.2, name: "transition"},
    ...runs.map(r => line(r, r.evolution.cycle, r.evolution.energy_ratio, {marks: r.evolution.cycle.length < 30}))]});
  const delta = {label: "displacement amplitude δa [µm]", log: true}, load = {label: "normal load P [N]", log: true};
  const slides = (r, name) => r.conditions ? [line(r, r.conditions.test_um, r.conditions.normal_load_N, {dash: "", name})] : [];
  const point = r => ({x: [r.evolution.displacement_amplitude_um.at(-1)], y: [r.evolution.normal_force_N.at(-1)], color: r.color, marks: true, radius: 6, width: 0,
    name: runs.length > 1 ? r.label : "this test"});
  const beyond = r => `${runs.length > 1 ? r.label + ": " : ""}slides beyond`;
  chart(by("conditions"), {x: delta, y: load, series: runs.flatMap(r => [
    ...(r.conditions ? [line(r, r.conditions.contact_um, r.conditions.normal_load_N, {dash: "5 3", width: 1.1, hidden: true})] : []), ...slides(r, beyond(r)), point(r)])});
  chart(by("response"), {x: delta, y: load, series: [...tensions(runs[0].tensions), ...runs.flatMap(r => [...slides(r, beyond(r)), point(r)])]});
}

offer({
  evolution: () => joined(runs, r => r.evolution),
  friction: () => joined(runs, r => r.friction),
  loops: () => joined(runs, r => ({cycle: r.loops.flatMap(l => l.x.map(() => l.cycle)), displacement_um: r.loops.flatMap(l => l.x), tangential_force_N: r.loops.flatMap(l => l.q)})),
  sections: () => joined(runs, r => {
    const rows = {body: [], cycle: [], x_um: [], unworn_um: [], depth_um: []};
    for (const body of Object.keys(r.scars ?? {})) for (const [k, cycle] of r.scars[body].cycles.entries()) r.scars[body].section.x.forEach((x, a) => {
      rows.body.push(body); rows.cycle.push(cycle); rows.x_um.push(x);
      rows.unworn_um.push(r.scars[body].section.unworn[a]); rows.depth_um.push(r.scars[body].section.depths[k][a]);
    });
    return rows;
  }),
});
const showNow = slideOver(cycles, showAll);
for (const id of ["which", "steep"]) by(id).addEventListener("change", showNow);
showNow();
showCourse();
