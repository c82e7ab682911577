// What an interactive view shows, and how it is drawn with a few primitives; parts of one script.
//
// Parallel projection, as in the pictures. `decode` reads the arrays of the page. A `Painter` knows
// camera, cut and order of drawing; `viewer_webgl.js` and `viewer_software.js` are the two ways to
// draw triangles and lines. `viewer_controls.js` joins the controls. Numbers are metres throughout.

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

class Painter {
  constructor(canvas, bodies, box) {
    Object.assign(this, { canvas, bodies, box });
    this.frame = { places: new Float32Array(24), normals: new Float32Array(24),
      triangles: new Uint16Array(0), lines: new Uint16Array(EDGES), shift: [0, 0, 0] };
    for (let i = 0; i < 8; i += 1) {
      for (let k = 0; k < 3; k += 1) this.frame.places[3 * i + k] = box[2 * k + (i >> k & 1)];
    }
    this.plane = { places: new Float32Array(12), normals: new Float32Array(12),
      triangles: new Uint16Array([0, 1, 2, 1, 3, 2]), lines: new Uint16Array(0) };
    this.state = { azimuth: 225, elevation: 28, zoom: 1, pan: [0, 0], explode: 0,
      exaggeration: 1, axis: "", level: 0.5, flip: false, picked: -1 };
  }

  // The primitives, besides `begin` and `section`:
  // part(body, "triangles" or "lines", colour, shaded, bias towards the viewer)
  // cutting(plane): half a space that is left out; moved(x, y): a shift in pixels
  // changed(body): its places or lines are new; finish(): the picture is complete

  // Directions of the screen, and the scale at which all that is shown fits into it.
  camera() {
    const s = this.state, a = rad(s.azimuth), e = rad(s.elevation);
    const towards = [Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), Math.sin(e)];
    const right = [-Math.cos(a), Math.sin(a), 0];
    const up = [-Math.sin(a) * Math.sin(e), -Math.cos(a) * Math.sin(e), Math.cos(e)];
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const bounds = this.bodies.map((b) => [b.bounds, b.shift]);
    bounds.push([[[0, 2, 4].map((k) => this.box[k]), [1, 3, 5].map((k) => this.box[k])],
      [0, 0, 0]]);
    const stretch = [1, 1, s.exaggeration], corners = [];
    for (const [box, shift] of bounds) {
      for (let i = 0; i < 8; i += 1) {
        const p = [0, 1, 2].map((k) => (box[i >> k & 1][k] + s.explode * shift[k]) * stretch[k]);
        corners.push(p);
        for (let k = 0; k < 3; k += 1) {
          low[k] = Math.min(low[k], p[k]);
          high[k] = Math.max(high[k], p[k]);
        }
      }
    }
    const middle = [0, 1, 2].map((k) => (low[k] + high[k]) / 2);
    const span = [right, up, towards].map((axis) => corners.reduce((most, p) =>
      Math.max(most, Math.abs(dot(axis, p.map((x, k) => x - middle[k])))), 1e-9));
    const { width, height } = this.canvas;
    const fit = 0.92 * Math.min(width / span[0], height / span[1]) * s.zoom;
    return { right, up, towards, stretch, depth: 0.9 / span[2],
      centre: middle.map((x, k) => x / stretch[k]), scale: [fit / width, fit / height] };
  }

  cut() {
    const { axis, level, flip } = this.state;
    const plane = [0, 0, 0, 1e30];
    if (axis) {
      const k = AXES[axis], sign = flip ? -1 : 1;
      plane[k] = sign;
      plane[3] = sign * (this.box[2 * k] + level * (this.box[2 * k + 1] - this.box[2 * k]));
    }
    return plane;
  }

  // The corners of the plane of the cut, a little larger than the model.
  place() {
    const { box, state, plane } = this, k = AXES[state.axis];
    if (k === undefined) return;
    const [u, v] = [0, 1, 2].filter((axis) => axis !== k);
    for (let i = 0; i < 4; i += 1) {
      plane.places[3 * i + k] = box[2 * k] + state.level * (box[2 * k + 1] - box[2 * k]);
      [u, v].forEach((axis, bit) => {
        const [low, high] = [box[2 * axis], box[2 * axis + 1]], more = 0.01 * (high - low);
        plane.places[3 * i + axis] = i >> bit & 1 ? high + more : low - more;
      });
    }
    this.changed(plane);
  }

  draw(background, ink) {
    const { state } = this;
    this.begin(background);
    this.bodies.forEach((body, i) => {
      if (!body.shown) return;
      const picked = i === state.picked;
      this.solid(body, body.rgb.map((x) => picked ? 0.45 * x + 0.55 : x), true);
      if (!body.triangles.length) this.thick(body, body.rgb, picked ? 2 : 1);
      else this.part(body, "lines", picked ? [0.78, 0.06, 0.18] : [0.1, 0.11, 0.13], false, 2e-3);
    });
    if (!state.explode) this.boxBehind(ink); // an exploded model has no common box
    this.finish();
  }

  // Bodies in the colours of their rows, for `pick`.
  drawRows() {
    this.begin([0, 0, 0]);
    this.bodies.forEach((body, i) => {
      const row = i + 1;
      const code = [row & 255, row >> 8 & 255, row >> 16].map((v) => v / 255);
      if (!body.shown) return;
      this.solid(body, code, false);
      if (!body.triangles.length) this.thick(body, code, 3); // easier to hit
    });
  }

  // The triangles of a body, and its section where it is cut.
  solid(body, colour, shaded) {
    this.part(body, "triangles", colour, shaded, 0);
    if (body.closed && this.state.axis) this.section(body, colour.map((x) => shaded ? 0.9 * x : x));
  }

  // Curves and fault sticks: primitives have lines of one pixel, so they are drawn side by side.
  thick(body, colour, width) {
    for (const [i, j] of [[0, 0], [width, 0], [-width, 0], [0, width], [0, -width]]) {
      this.moved(i, j);
      this.part(body, "lines", colour, false, 3e-3);
    }
    this.moved(0, 0);
  }

  // The edges of the box, except those at the corner next to the viewer.
  boxBehind(ink) {
    const nearest = this.camera().towards.reduce((row, x, k) => row | (x > 1e-6) << k, 0);
    const behind = [];
    for (let i = 0; i < EDGES.length; i += 2) {
      if (EDGES[i] !== nearest && EDGES[i + 1] !== nearest) behind.push(EDGES[i], EDGES[i + 1]);
    }
    this.frame.lines = new Uint16Array(behind);
    this.changed(this.frame);
    this.cutting(UNCUT);
    this.part(this.frame, "lines", ink, false, 0);
  }
}
