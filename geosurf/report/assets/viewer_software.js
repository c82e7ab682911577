// Triangles and lines without WebGL: a depth for each pixel, scan line by scan line.
//
// A pixel belongs to the triangle that its middle is in. Places where edges cross a scan line are
// computed alike for both triangles at an edge, so that no pixel is left out or counted twice.

const SEEN = 6; // numbers for each point: place on the screen, depth, and normal
const [PAINT, COUNT, INSIDE] = [0, 1, 2];

class SoftwarePainter extends Painter {
  constructor(canvas, bodies, box) {
    super(canvas, bodies, box);
    this.ratio = 1.5; // pixels of the picture for each of the page: the browser makes them smooth
    this.page = canvas.getContext("2d");
  }

  begin(background) {
    const { width, height } = this.canvas, n = width * height;
    if (this.depths?.length !== n || this.image.width !== width) {
      this.image = this.page.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      [this.depths, this.inside] = [new Float32Array(n), new Int16Array(n)];
    }
    this.pixels.fill(packed(background));
    this.depths.fill(-Infinity);
    this.look = this.camera();
    this.seen = new Map();
    this.moved(0, 0);
    this.cutting(this.cut());
    this.place();
  }

  changed(body) {
    this.seen.delete(body);
  }

  cutting(plane) {
    this.half = plane;
  }

  moved(i, j) {
    this.shift = [i, j];
  }

  finish() {
    this.page.putImageData(this.image, 0, 0);
  }

  part(body, name, colour, shaded, bias) {
    if (name === "lines") this.lines(body, packed(colour), bias);
    else this.triangles(body, colour, shaded, PAINT);
  }

  // Where more backs than fronts lie behind the plane of the cut, the plane is inside the body.
  section(body, colour) {
    this.inside.fill(0);
    this.triangles(body, colour, false, COUNT);
    this.cutting(UNCUT);
    this.plane.shift = body.shift;
    this.changed(this.plane);
    this.triangles(this.plane, colour, false, INSIDE);
    this.cutting(this.cut());
  }

  pick(x, y) {
    this.drawRows();
    const pixel = this.pixels[y * this.canvas.width + x];
    return (pixel & 0xffffff) - 1;
  }

  // Points and normals of a body as the viewer sees them.
  project(body) {
    if (this.seen.has(body)) return this.seen.get(body);
    const { right, up, towards, stretch, centre, scale, depth } = this.look;
    const { width, height } = this.canvas, { pan, explode } = this.state;
    const { places, normals } = body, result = new Float64Array(places.length * SEEN / 3);
    const at = [0, 0, 0], normal = [0, 0, 0];
    for (let i = 0, j = 0; i < places.length; i += 3, j += SEEN) {
      for (let k = 0; k < 3; k += 1) {
        at[k] = (places[i + k] + explode * body.shift[k] - centre[k]) * stretch[k];
        normal[k] = normals[i + k] / stretch[k];
      }
      result[j] = (dot(right, at) * scale[0] + pan[0] + 1) * width / 2;
      result[j + 1] = (1 - dot(up, at) * scale[1] - pan[1]) * height / 2;
      result[j + 2] = dot(towards, at) * depth;
      const seen = [dot(right, normal), dot(up, normal), dot(towards, normal)];
      result.set(unit(seen[2] < 0 ? seen.map((x) => -x) : seen), j + 3);
    }
    this.seen.set(body, result);
    return result;
  }

  // How far a point is beyond the cut; above 0 it is left out.
  beyond(body, i) {
    const { half } = this, p = body.places;
    return half[0] * p[3 * i] + half[1] * p[3 * i + 1] + half[2] * p[3 * i + 2] - half[3];
  }

  triangles(body, colour, shaded, mode) {
    const { pixels, depths, inside } = this, { width, height } = this.canvas;
    const points = this.project(body), rows = body.triangles, plain = packed(colour);
    const [red, green, blue] = colour.map((v) => 255 * v);
    const up = this.look.scale[0] * width / 2 / this.look.depth; // pixels for one of depth
    const x = [0, 0, 0], y = [0, 0, 0], z = [0, 0, 0], far = [0, 0, 0], light = [1, 1, 1];
    for (let t = 0; t < rows.length; t += 3) {
      for (let k = 0; k < 3; k += 1) {
        const j = SEEN * rows[t + k];
        [x[k], y[k], z[k]] = [points[j], points[j + 1], points[j + 2]];
        far[k] = this.beyond(body, rows[t + k]);
      }
      const first = Math.max(0, Math.ceil(least(y) - 0.5));
      const last = Math.min(height, Math.ceil(most(y) - 0.5));
      if (first >= last || least(far) > 0) continue;
      const [bx, by, cx, cy] = [x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]];
      const area = bx * cy - cx * by;
      if (shaded) {
        const [bz, cz] = [(z[1] - z[0]) * up, (z[2] - z[0]) * up], turn = area > 0 ? -1 : 1;
        const crease = unit([turn * (cy * bz - by * cz), turn * (cx * bz - bx * cz), turn * -area]);
        for (let k = 0; k < 3; k += 1) {
          const j = SEEN * rows[t + k] + 3, n = [points[j], points[j + 1], points[j + 2]];
          light[k] = brightness(dot(n, crease) < 0.8 ? crease : n);
        }
      }
      const inverse = area ? 1 / area : 0;
      const slope = (v) => [((v[1] - v[0]) * cy - (v[2] - v[0]) * by) * inverse,
        ((v[2] - v[0]) * bx - (v[1] - v[0]) * cx) * inverse, least(v), most(v)];
      const [zx, zy, zLow, zHigh] = slope(z), [lx, ly, lLow, lHigh] = slope(light);
      const partly = most(far) > 0, [fx, fy] = partly ? slope(far) : [0, 0];
      for (let row = first; row < last; row += 1) {
        const middle = row + 0.5, ends = crossings(x, y, middle);
        if (!ends) continue;
        const [left, right, way] = ends, dy = middle - y[0];
        const end = Math.min(width, Math.ceil(right - 0.5));
        for (let column = Math.max(0, Math.ceil(left - 0.5)); column < end; column += 1) {
          const i = row * width + column, dx = column + 0.5 - x[0];
          if (partly && far[0] + fx * dx + fy * dy > 0) continue;
          if (mode === COUNT) {
            inside[i] += way;
            continue;
          }
          if (mode === INSIDE && !inside[i]) continue;
          const near = Math.min(zHigh, Math.max(zLow, z[0] + zx * dx + zy * dy));
          if (near < depths[i]) continue;
          depths[i] = near;
          if (!shaded) {
            pixels[i] = plain;
            continue;
          }
          const lit = Math.min(lHigh, Math.max(lLow, light[0] + lx * dx + ly * dy));
          pixels[i] = 0xff000000 | Math.min(255, blue * lit) << 16
            | Math.min(255, green * lit) << 8 | Math.min(255, red * lit);
        }
      }
    }
  }

  lines(body, colour, bias) {
    const { pixels, depths } = this, { width, height } = this.canvas;
    const points = this.project(body), rows = body.lines, size = [width, height];
    for (let t = 0; t < rows.length; t += 2) {
      const [a, b] = [SEEN * rows[t], SEEN * rows[t + 1]];
      const from = [points[a] + this.shift[0], points[a + 1] - this.shift[1]];
      const along = [points[b] - points[a], points[b + 1] - points[a + 1]];
      const [near, farther] = [points[a + 2], points[b + 2] - points[a + 2]];
      const out = this.beyond(body, rows[t]), more = this.beyond(body, rows[t + 1]) - out;
      let [start, end] = [0, 1]; // the part that is on the screen
      along.forEach((step, k) => {
        const [p, q] = [-from[k] / step, (size[k] - from[k]) / step];
        if (!step && (from[k] < 0 || from[k] >= size[k])) end = -1;
        if (!step) return;
        start = Math.max(start, Math.min(p, q));
        end = Math.min(end, Math.max(p, q));
      });
      const n = Math.ceil(Math.max(Math.abs(along[0]), Math.abs(along[1]))) || 1;
      for (let k = Math.ceil(start * n); k <= Math.floor(end * n); k += 1) {
        const share = k / n, depth = near + share * farther + bias;
        const column = Math.floor(from[0] + share * along[0]);
        const row = Math.floor(from[1] + share * along[1]), i = row * width + column;
        if (column < 0 || row < 0 || column >= width || row >= height) continue;
        if (depth < depths[i] || out + share * more > 0) continue;
        depths[i] = depth;
        pixels[i] = colour;
      }
    }
  }
}

// Where the outline of a triangle crosses a scan line, from left to right, and whether the left
// crossing goes up or down.
function crossings(x, y, middle) {
  let [n, left, right, way] = [0, 0, 0, 0];
  for (let k = 0; k < 3; k += 1) {
    const j = (k + 1) % 3, down = y[k] <= middle && middle < y[j];
    if (!down && !(y[j] <= middle && middle < y[k])) continue;
    const [a, b] = down ? [k, j] : [j, k]; // the same order for both triangles at this edge
    const at = x[a] + (middle - y[a]) * (x[b] - x[a]) / (y[b] - y[a]), turn = down ? 1 : -1;
    if (n === 0 || at < left) [left, right, way] = [at, n ? left : at, turn];
    else right = at;
    n += 1;
  }
  return n === 2 ? [left, right, way] : null;
}

const least = ([a, b, c]) => Math.min(a, b, c);
const most = ([a, b, c]) => Math.max(a, b, c);

function unit(v) {
  const size = Math.hypot(...v) || 1;
  return v.map((x) => x / size);
}

function brightness(normal) {
  return 0.6 + 0.42 * Math.max(dot(normal, LIT) / Math.hypot(...LIT), 0);
}

// A colour as the browser stores it: red, green, blue, opaque.
function packed(colour) {
  const [r, g, b] = colour.map((x) => Math.round(255 * x));
  return (0xff000000 | b << 16 | g << 8 | r) >>> 0;
}
