"use strict";
/* A worn surface in 3D on a canvas, turned by dragging or by the arrow keys: quads drawn from the back to the front.
   A height field needs no more than that, so that the page works without WebGL and stays small. */
class Surface {
  constructor(canvas, colours) {
    this.canvas = canvas;
    this.colours = colours;
    this.azimuth = -62;
    this.elevation = 38;
    this.zoom = 1;
    this.field = null;
    this.listen();
  }

  /* field: {x, y (lines), z, depth (rows over x, null where nothing is), deepest, exaggeration} in µm. */
  show(field) {
    this.field = field;
    this.draw();
  }

  listen() {
    let from = null;
    this.canvas.addEventListener("pointerdown", e => {
      from = [e.clientX, e.clientY, this.azimuth, this.elevation];
      this.canvas.setPointerCapture(e.pointerId);
    });
    this.canvas.addEventListener("pointermove", e => {
      if (!from) return;
      this.turn(from[2] - 0.4 * (e.clientX - from[0]), from[3] + (e.pointerType === "mouse" ? 0.4 * (e.clientY - from[1]) : 0));
    });
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => { from = null; });
    this.canvas.addEventListener("keydown", e => {
      const by = {ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, 6], ArrowDown: [0, -6]}[e.key];
      if (!by) return;
      e.preventDefault();
      this.turn(this.azimuth + by[0], this.elevation + by[1]);
    });
  }

  turn(azimuth, elevation) {
    this.azimuth = azimuth;
    this.elevation = Math.min(Math.max(elevation, 8), 88);
    cancelAnimationFrame(this.waiting);
    this.waiting = requestAnimationFrame(() => this.draw());
  }

  draw() {
    if (!this.field) return;
    const sharp = Math.min(window.devicePixelRatio || 1, 2), wide = this.canvas.clientWidth, high = Math.round(Math.min(0.78 * wide, 430));
    this.canvas.style.height = `${high}px`;
    this.canvas.width = wide * sharp;
    this.canvas.height = high * sharp;
    const pen = this.canvas.getContext("2d");
    pen.scale(sharp, sharp);
    pen.clearRect(0, 0, wide, high);
    const {x, y, z, depth, deepest, exaggeration} = this.field, a = this.azimuth * Math.PI / 180, e = this.elevation * Math.PI / 180;
    const right = [-Math.sin(a), Math.cos(a), 0], eye = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const up = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
    const reach = Math.hypot(x[x.length - 1], y[y.length - 1]), scale = 0.5 * Math.min(wide, 1.25 * high) / reach;
    const cx = wide / 2, cy = high * 0.46, n = x.length, m = y.length;
    const px = new Float32Array(n * m), py = new Float32Array(n * m);
    for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) {
      const h = (z[i][j] ?? 0) * exaggeration, at = i * m + j;
      px[at] = cx + scale * (x[i] * right[0] + y[j] * right[1]);
      py[at] = cy - scale * (x[i] * up[0] + y[j] * up[1] + h * up[2]);
    }
    const rows = eye[0] > 0 ? [...Array(n - 1).keys()] : [...Array(n - 1).keys()].reverse();
    const columns = eye[1] > 0 ? [...Array(m - 1).keys()] : [...Array(m - 1).keys()].reverse();
    const sun = [-0.52, -0.30, 0.80];
    for (const i of rows) for (const j of columns) {
      const [p, q, r, s] = [z[i][j], z[i + 1][j], z[i + 1][j + 1], z[i][j + 1]];
      if (p === null || q === null || r === null || s === null) continue;
      const dx = exaggeration * (q + r - p - s) / (2 * (x[i + 1] - x[i])), dy = exaggeration * (r + s - p - q) / (2 * (y[j + 1] - y[j]));
      const size = Math.hypot(dx, dy, 1), light = 0.45 + 0.55 * Math.max((sun[2] - dx * sun[0] - dy * sun[1]) / size, 0);
      const deep = (depth[i][j] + depth[i + 1][j] + depth[i + 1][j + 1] + depth[i][j + 1]) / 4;
      const c = this.colours[Math.min(this.colours.length - 1, Math.floor(deep / deepest * this.colours.length))];
      pen.fillStyle = pen.strokeStyle = `rgb(${c[0] * light | 0},${c[1] * light | 0},${c[2] * light | 0})`;
      const k = i * m + j;
      pen.beginPath();
      pen.moveTo(px[k], py[k]);
      pen.lineTo(px[k + m], py[k + m]);
      pen.lineTo(px[k + m + 1], py[k + m + 1]);
      pen.lineTo(px[k + 1], py[k + 1]);
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
    this.arrow(pen, right, up, scale, wide, high);
    this.canvas.dataset.azimuth = this.azimuth.toFixed(1);
    this.canvas.dataset.deepest = Math.max(...depth.map(row => Math.max(...row.map(v => v ?? 0)))).toFixed(3);
  }

  /* The direction of sliding, and a length to compare with. */
  arrow(pen, right, up, scale, wide, high) {
    const length = [500, 200, 100, 50, 20, 10, 5, 2, 1].find(l => l * scale < 0.28 * wide) ?? 1;
    const dx = length * scale * right[0], dy = -length * scale * up[0], x = 0.06 * wide + Math.max(-dx, 0), y = high - 26 - Math.max(dy, 0);
    pen.strokeStyle = pen.fillStyle = "#1a1a1a";
    pen.lineWidth = 1.6;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + dx, y + dy);
    pen.stroke();
    for (const [ax, ay] of [[x, y], [x + dx, y + dy]]) { pen.beginPath(); pen.arc(ax, ay, 2.6, 0, 7); pen.fill(); }
    pen.font = "11.5px DejaVu Sans, Segoe UI, Helvetica, Arial, sans-serif";
    pen.fillText(`x, sliding: ${length} µm`, 0.06 * wide, high - 6);
  }
}
