"use strict";
/* The fretting log: loops as slices along a logarithmic axis of cycles that runs to the right and backwards. */
function frettingLog(element, run, place, unit) {
  const width = Math.max(element.clientWidth, 200), height = Math.round(Math.min(0.72 * width, 360));
  const picture = node("svg", {viewBox: `0 0 ${width} ${height}`, height, role: "img", "aria-label": "fretting log"});
  const loops = run.loops, last = loops.length - 1;
  const logs = loops.map(l => Math.log10(Math.max(l.cycle, 1))), most = Math.max(...logs, 1e-9);
  const reachX = Math.max(...loops.flatMap(l => l.x.map(Math.abs))), reachQ = Math.max(...loops.flatMap(l => l.q.map(Math.abs)));
  const half = 0.24 * width, high = 0.26 * height, right = Math.min(0.38 * width, width - 2 * half - 82), back = 0.30 * height;
  const x0 = half + 14, y0 = height - high - 34;
  const at = (x, q, share) => [x0 + half * x / reachX + right * share, y0 - high * q / reachQ - back * share];
  const line = (from, to, cls) => node("line", {x1: from[0], y1: from[1], x2: to[0], y2: to[1], class: cls}, picture);
  line(at(-reachX, -reachQ, 0), at(reachX, -reachQ, 0), "axis");
  line(at(-reachX, -reachQ, 0), at(-reachX, reachQ, 0), "axis");
  line(at(reachX, -reachQ, 0), at(reachX, -reachQ, 1), "axis");
  for (let k = last; k >= 0; k--) {
    const share = logs[k] / most, points = loops[k].x.map((x, i) => at(x, loops[k].q[i], share));
    const here = k === place;
    node("path", {d: pathOf(points.map(p => p[0]), points.map(p => p[1]), true), fill: run.color, "fill-opacity": here ? .35 : .06,
      stroke: run.color, "stroke-width": here ? 2.2 : 1.1}, picture);
  }
  let behind = -1;
  loops.forEach((loop, k) => {
    const share = logs[k] / most, end = at(reachX, -reachQ, share);
    if (Math.abs(logs[k] - Math.round(logs[k])) > 1e-9 || share - behind < 0.13 && behind >= 0) return;
    behind = share;
    line(end, [end[0] + 5, end[1] + 2], "axis");
    node("text", {x: end[0] + 8, y: end[1] + 9}, picture, figure(loop.cycle));
  });
  const [qx, qy] = at(-reachX, reachQ, 0), [dx, dy] = at(0, -reachQ, 0), [nx, ny] = at(reachX, -reachQ, 0.5);
  node("text", {x: Math.max(qx - 6, 2), y: qy - 8}, picture, `Q, ±${figure(reachQ, 3)} ${unit}`);
  node("text", {x: dx, y: dy + 17, "text-anchor": "middle"}, picture, `δ, ±${figure(reachX, 3)} µm`);
  node("text", {x: Math.min(nx + 44, width - 52), y: Math.min(ny + 40, height - 4)}, picture, "cycles N");
  element.classList.add("chart");
  element.replaceChildren(picture);
}
