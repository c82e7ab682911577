// What an interactive view shows; parts of one script.
//
// Parallel projection, as in the pictures. `decode` reads the arrays of the page. The `Painter` of
// `viewer_painter.js` draws them by WebGL 2, `viewer_controls.js` joins the controls. Numbers are
// metres throughout.

const AXES = { easting: 0, northing: 1, elevation: 2 };
const VIEWS = { southwest: [225, 28], southeast: [135, 28], northwest: [315, 28],
  northeast: [45, 28], south: [180, 0], west: [270, 0], top: [180, 90] };
const rad = (degrees) => degrees * Math.PI / 180;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const rgb = (code) => [1, 3, 5].map((i) => parseInt(code.slice(i, i + 2), 16) / 255);
const grouped = (x) => Math.round(x).toString().replace("-", "\u2212")
  .replace(/\B(?=(\d{3})+$)/g, "\u202f");
// edges of a box by its corners: bit k of a corner is its side along axis k
const EDGES = [0, 1, 0, 2, 0, 4, 1, 3, 1, 5, 2, 3, 2, 6, 3, 7, 4, 5, 4, 6, 5, 7, 6, 7];
const UNCUT = [0, 0, 0, 1e30];
const LIT = [-0.35, 0.65, 0.7]; // where the light comes from, on the screen

function decode(head, base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i += 1) bytes[i] = text.charCodeAt(i);
  const list = ([kind, offset, count]) =>
    new { u2: Uint16Array, u4: Uint32Array }[kind](bytes.buffer, offset, count);
  return head.bodies.map((body) => {
    const steps = list(body.points), places = new Float32Array(steps.length);
    for (let i = 0; i < steps.length; i += 1) places[i] = steps[i] * head.step[i % 3];
    const triangles = list(body.triangles);
    return { ...body, shown: true, places, triangles, lines: list(body.lines), rgb: rgb(body.colour),
      normals: normalsOf(places, triangles), bounds: boundsOf(places) };
  });
}

function normalsOf(p, triangles) {
  const n = new Float32Array(p.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const u = [0, 1, 2].map((k) => p[b + k] - p[a + k]);
    const v = [0, 1, 2].map((k) => p[c + k] - p[a + k]);
    const w = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const i of [a, b, c]) for (let k = 0; k < 3; k += 1) n[i + k] += w[k];
  }
  // corners of slivers without area take the normals of the others
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [0, 1, 2].map((k) => 3 * triangles[t + k]);
    for (const i of corners) {
      if (n[i] || n[i + 1] || n[i + 2]) continue;
      for (let k = 0; k < 3; k += 1) n[i + k] = corners.reduce((sum, j) => sum + n[j + k], 0);
    }
  }
  for (let i = 0; i < n.length; i += 3) {
    const size = Math.hypot(n[i], n[i + 1], n[i + 2]) || 1;
    for (let k = 0; k < 3; k += 1) n[i + k] /= size;
  }
  return n;
}

function boundsOf(p) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < p.length; i += 1) {
    low[i % 3] = Math.min(low[i % 3], p[i]);
    high[i % 3] = Math.max(high[i % 3], p[i]);
  }
  return [low, high];
}
