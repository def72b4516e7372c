"use strict";
const data = JSON.parse(by("data").textContent), runs = data.runs;
const cycles = [...new Set(runs.flatMap(r => r.loops.map(l => l.cycle)))].sort((a, b) => a - b);
const scarRuns = runs.filter(r => r.scars);
const units = runs[0].units, several = runs.length > 1;
const course = (r, y, more = {}) => line(r, r.courses.cycle, y, {marks: r.courses.cycle.length < 30, ...more});
const column = (name, label) => chart(by(name), {x: CYCLES, y: {label: `${label} [${units[name]}]`}, series: runs.map(r => course(r, r.courses[name]))});
const named = (r, words) => [several ? r.label : "", words].filter(Boolean).join(", ");

function showWords(cycle) {
  by("loop-words").textContent = runs.map(r => {
    const k = near(r.courses.cycle, cycle), e = r.courses;
    return `${several ? r.label + ": " : ""}slip δ0 ${figure(e.slip[k], 3)} µm, energy ${figure(e.energy[k], 3)} ${units.energy}, largest Q ${figure(e.force[k], 3)} ${units.force}, energy ratio ${figure(e.ratio[k], 2)}`;
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

const maps = scarRuns.some(r => Object.values(r.scars).some(s => s.lines));
const surface = maps ? new Surface(by("scar"), data.shades) : null;
by("scar-card").hidden = !maps;
by("section-card").hidden = by("which").hidden = !scarRuns.length;
const choices = scarRuns.flatMap((r, i) => Object.keys(r.scars).map(b => [i, b]));
for (const [i, body] of choices) by("which").add(new Option(`${scarRuns.length > 1 ? scarRuns[i].label + ", " : ""}${scarRuns[i].scars[body].called}`, `${i} ${body}`));
function showScar(cycle) {
  if (!scarRuns.length) return;
  const [i, body] = by("which").value.split(" "), scar = scarRuns[i].scars[body];
  if (maps) {
    const k = near(scar.cycles, cycle), depth = unpacked(scar, k), steep = by("steep").checked ? 4 : 1;
    const z = scar.unworn.map((row, a) => row.map((h, b) => h === null ? null : h / steep - depth[a][b]));
    surface.show({x: scar.lines, y: scar.lines, z, depth, deepest: scar.deepest, exaggeration: steep});
    by("scale").textContent = `Cycle ${figure(scar.cycles[k])}: ${figure(Math.max(...depth.map(r => Math.max(...r))), 3)} µm deep; dark is ${figure(scar.deepest, 3)} µm.` +
      scar.section.layers.map((face, k) => ` Layer ${k + 1} is worn through on ${figure(1e-6 * (scar.lines[1] - scar.lines[0]) ** 2 * depth.flat().filter(d => d >= face).length, 3)} mm².`).join("");
  }
  const shown = scarRuns.map(r => [r, r.scars[body]]), own = shown[0][1].section, heights = shown.flatMap(([, s]) => s.section.unworn.map((h, a) => h - s.section.depths[s.cycles.length - 1][a]));
  const low = 1.5 * Math.min(...shown.map(([, s]) => -s.deepest + Math.min(0, ...s.section.unworn.filter((h, a) => s.section.depths[s.cycles.length - 1][a] > 0))), -1e-3);
  const x = {label: "position along the motion x [µm]"};
  chart(by("section"), {x, y: {label: `height z, ${scar.called} [µm]`, min: Math.max(low, Math.min(...heights)), max: -0.12 * low}, series: [
    {x: own.x, y: own.unworn, color: "#8a8a8a", dash: "4 3", width: 1.2, name: "unworn"},
    ...own.layers.map((face, k) => ({x: own.x, y: own.unworn.map(h => h - face), color: "#8a8a8a", dash: "1 3", width: 1.2, name: `below layer ${k + 1}`})),
    ...shown.map(([r, s]) => line(r, s.section.x, s.section.unworn.map((h, a) => h - s.section.depths[near(s.cycles, cycle)][a]), {kind: "worn"}))]});
  for (const [name, label] of Object.entries({pressure_MPa: "pressure [MPa]", slip_amplitude_um: "slip amplitude [µm]"})) if (scar.profiles)
    chart(by(name), {x, y: {label: `${label}, ${scar.called}`, zero: true}, series: shown.map(([r, s]) => line(r, s.section.x, s.profiles[name][near(s.cycles, cycle)]))});
}

function showAll(cycle) {
  showLoops(runs, cycle, units.force);
  showWords(cycle);
  showScar(cycle);
}

function showCourse() {
  chart(by("amplitudes"), {x: CYCLES, y: {label: "amplitude [µm]"}, series: [
    {x: runs[0].courses.cycle, y: runs[0].courses.amplitude, color: "#1a1a1a", width: 1.2, name: "displacement δa"},
    ...runs.map(r => course(r, r.courses.slip, {name: `slip δ0${several ? ", " + r.label : ""}`}))]});
  chart(by("friction"), {x: CYCLES, y: {label: "coefficient of friction µ", least: .2}, series: runs.flatMap(r => [
    line(r, r.friction.cycle, r.friction.friction_max, {marks: true, dash: ""}),
    line(r, r.friction.cycle, r.friction.friction_energy, {dash: "", width: 1, hidden: true}),
    line(r, r.friction.cycle, r.friction.friction_geometry_independent, {dash: "5 3", width: 1.4, hidden: true})])});
  column("energy", "energy per cycle");
  column("force", "largest tangential force");
  chart(by("depth"), {x: CYCLES, y: {label: "depth [µm]", log: true}, series: runs.flatMap(r => r.depths.map(([called, depth], k) =>
    line(r, r.courses.cycle, depth, {dash: ["", "5 3"][k], name: named(r, called)})))});
  chart(by("volume"), {x: {label: `friction energy ΣE [${units.worked}]`, zero: true}, y: {label: `worn volume V [${units.worn}]`, zero: true}, series: runs.flatMap(r => {
    const end = Math.max(...r.courses.worked);
    return [line(r, r.courses.worked, r.courses.worn, {marks: true, width: 0}),
      line(r, [0, end], [0, r.worn_per_mm3 * (r.slope_mm3_per_J ?? 0) * end], {hidden: true, width: 1.2, dash: ""})];
  })});
  by("slope").textContent = runs.map(r => `${several ? r.label + ": s" : "S"}lope ${figure(r.slope_mm3_per_J, 3)} mm³/J`).join("; ") + ", of the line through the origin.";
  chart(by("pressure"), {x: CYCLES, y: {label: "pressure [MPa]", log: true}, series: runs.flatMap(r => r.pressures.map(([words, dash, values]) => course(r, values, {dash, name: named(r, words)})))});
  chart(by("ratio"), {x: CYCLES, y: {label: "energy ratio A", min: 0, max: 1}, series: [
    {x: [cycles[0] ?? 1, cycles[cycles.length - 1] ?? 10], y: [.2, .2], color: "#8a8a8a", dash: "4 3", width: 1.2, name: "transition"},
    ...runs.map(r => course(r, r.courses.ratio))]});
  if (!by("conditions")) return;
  const delta = {label: "displacement amplitude δa [µm]", log: true}, load = {label: "normal load P [N]", log: true};
  const slides = (r, name) => r.conditions ? [line(r, r.conditions.test_um, r.conditions.normal_load_N, {dash: "", name})] : [];
  // Runs of one load and stroke lie on each other: the earlier the wider.
  const at = r => [r.courses.amplitude.at(-1), r.courses.load.at(-1)];
  const above = r => runs.slice(runs.indexOf(r) + 1).filter(o => at(o).every((v, k) => Math.abs(v - at(r)[k]) < .05 * v)).length;
  const point = r => ({x: [at(r)[0]], y: [at(r)[1]], color: r.color, marks: true, radius: 6 + 4 * above(r), width: 0, name: several ? r.label : "this test"});
  const beyond = r => `${several ? r.label + ": " : ""}slides beyond`;
  chart(by("conditions"), {x: delta, y: load, series: runs.flatMap(r => [
    ...(r.conditions ? [line(r, r.conditions.contact_um, r.conditions.normal_load_N, {dash: "5 3", width: 1.1, hidden: true})] : []), ...slides(r, beyond(r)), point(r)])});
  chart(by("response"), {x: delta, y: load, series: [...tensions(runs[0].tensions), ...runs.flatMap(r => [...slides(r, beyond(r)), point(r)])]});
}

offer({
  evolution: () => joined(runs, r => r.evolution),
  friction: () => joined(runs, r => r.friction),
  loops: () => joined(runs, r => ({cycle: r.loops.flatMap(l => l.x.map(() => l.cycle)), displacement_um: r.loops.flatMap(l => l.x), [`tangential_force_${units.force.replace("/", "_per_")}`]: r.loops.flatMap(l => l.q)})),
  sections: () => joined(runs, r => {
    const rows = {body: [], cycle: [], x_um: [], unworn_um: [], depth_um: []}, profiles = Object.values(r.scars ?? {})[0]?.profiles ?? {};
    for (const name of Object.keys(profiles)) rows[name] = [];
    for (const body of Object.keys(r.scars ?? {})) for (const [k, cycle] of r.scars[body].cycles.entries()) r.scars[body].section.x.forEach((x, a) => {
      rows.body.push(body); rows.cycle.push(cycle); rows.x_um.push(x);
      rows.unworn_um.push(r.scars[body].section.unworn[a]); rows.depth_um.push(r.scars[body].section.depths[k][a]);
      for (const name of Object.keys(profiles)) rows[name].push(r.scars[body].profiles[name][k][a]);
    });
    return rows;
  }),
});
const showNow = slideOver(cycles, showAll);
for (const id of ["which", "steep"]) by(id).addEventListener("change", showNow);
showNow();
showCourse();
