"use strict";
const data = JSON.parse(by("data").textContent), runs = data.runs;
const cycles = [...new Set(runs.flatMap(r => r.loops.map(l => l.cycle)))].sort((a, b) => a - b);
const deepest = Math.max(...runs.flatMap(r => r.profiles.flatMap(p => ["pad", "specimen"].flatMap(b => p[b].depth_um))), 1e-3);

function show(cycle) {
  showLoops(runs, cycle, "N/mm");
  const now = runs.map(r => r.profiles.length ? [r, r.profiles[near(r.profiles, cycle, p => p.cycle)]] : null).filter(Boolean);
  chart(by("depth"), {x: {label: "position x [µm]"}, y: {label: "height against unworn [µm]", min: -1.08 * deepest, max: 0.08 * deepest}, series: now.flatMap(([r, p]) => [
    line(r, p.specimen.x_um, p.specimen.depth_um.map(d => -d), {dash: "", kind: "worn"}),
    line(r, p.pad.x_um, p.pad.depth_um.map(d => -d), {dash: "5 3", width: 1.3, hidden: true})])});
  chart(by("pressure"), {x: {label: "position x [µm]"}, y: {label: "pressure [MPa]", zero: true}, series: now.map(([r, p]) => line(r, p.specimen.x_um, p.specimen.pressure_MPa))});
  chart(by("slip"), {x: {label: "position x [µm]"}, y: {label: "slip amplitude [µm]", zero: true}, series: now.map(([r, p]) => line(r, p.specimen.x_um, p.specimen.slip_amplitude_um))});
}

function course(id, label, columns, more = {}) {
  chart(by(id), {x: CYCLES, y: {label, ...more}, series: runs.flatMap(r => (columns instanceof Function ? columns(r) : columns).filter(([name]) => r.evolution[name]).map(([name, words, dash]) =>
    line(r, r.evolution.cycle, r.evolution[name], {dash, name: [runs.length > 1 ? r.label : "", words].filter(Boolean).join(", ") || r.label, marks: r.evolution.cycle.length < 30})))});
}
course("amplitudes", "amplitude [µm]", [["displacement_amplitude_um", "displacement δa", "2 3"], ["slip_amplitude_um", "slip δ0", ""]]);
course("force", "largest force [N/mm]", [["max_tangential_force_N_per_mm", "", ""]]);
course("energy", "energy per cycle [mJ/mm]", [["dissipated_energy_mJ_per_mm", "", ""]]);
course("worn", "depth [µm]", [["specimen_max_depth_um", "specimen", ""], ["pad_max_depth_um", "pad", "5 3"]], {log: true});
course("peak", "pressure [MPa]", r => r.pressures, {log: true});
chart(by("volume"), {x: {label: "friction energy ΣE [J/mm]", zero: true}, y: {label: "worn area, both bodies [µm²]", zero: true}, series: runs.map(r =>
  line(r, r.evolution.accumulated_energy_J_per_mm, r.evolution.pad_worn_area_um2.map((a, k) => a + r.evolution.specimen_worn_area_um2[k]), {marks: true}))});
offer({
  evolution: () => joined(runs, r => r.evolution),
  loops: () => joined(runs, r => ({cycle: r.loops.flatMap(l => l.x.map(() => l.cycle)), displacement_um: r.loops.flatMap(l => l.x), tangential_force_N_per_mm: r.loops.flatMap(l => l.q)})),
  profiles: () => joined(runs, r => {
    const rows = {body: [], cycle: [], x_um: [], depth_um: [], pressure_MPa: []};
    for (const p of r.profiles) for (const body of ["pad", "specimen"]) p[body].x_um.forEach((x, k) => {
      rows.body.push(body); rows.cycle.push(p.cycle); rows.x_um.push(x);
      rows.depth_um.push(p[body].depth_um[k]); rows.pressure_MPa.push(p[body].pressure_MPa[k]);
    });
    return rows;
  }),
});
slideOver(cycles, show)();
