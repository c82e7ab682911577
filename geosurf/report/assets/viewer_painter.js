// Camera, cut and order of drawing; triangles and lines by WebGL 2.

const VERTEX = `#version 300 es
  in vec3 place, normal;
  uniform vec3 shift, centre, stretch, right, up, towards;
  uniform vec2 scale, pan;
  uniform float depth, bias;
  out vec3 at, seen, turned;
  vec3 view(vec3 v) { return vec3(dot(right, v), dot(up, v), dot(towards, v)); }
  void main() {
    at = place;
    seen = view((place + shift - centre) * stretch);
    turned = view(normal / stretch);
    gl_Position = vec4(seen.xy * scale + pan, -seen.z * depth - bias, 1.0);
  }`;

// Points of two surfaces are two points, so normals are smooth within a surface only; at a crease
// inside of one, the normal of the triangle counts.
const FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 at, seen, turned;
  uniform vec3 colour;
  uniform vec4 cut;
  uniform bool shaded;
  out vec4 paint;
  void main() {
    if (dot(cut.xyz, at) > cut.w) discard;
    float light = 1.0;
    if (shaded) {
      vec3 n = normalize(turned.z < 0.0 ? -turned : turned);
      vec3 crease = normalize(cross(dFdx(seen), dFdy(seen)));
      if (dot(n, crease) < 0.8) n = crease;
      light = 0.6 + 0.42 * max(dot(n, normalize(vec3(${LIT}))), 0.0);
    }
    paint = vec4(colour * light, 1.0);
  }`;

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
    this.gl = canvas.getContext("webgl2", { antialias: true, stencil: true });
    if (!this.gl) throw new Error("the browser has no WebGL 2");
    this.program = this.link();
    this.gl.useProgram(this.program);
    this.where = {};
    for (const name of ["shift", "centre", "stretch", "right", "up", "towards", "scale", "pan",
      "depth", "bias", "colour", "cut", "shaded"]) {
      this.where[name] = this.gl.getUniformLocation(this.program, name);
    }
    for (const body of [...bodies, this.frame, this.plane]) this.upload(body);
  }

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

  // Curves and fault sticks: WebGL has lines of one pixel, so they are drawn side by side.
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

  link() {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
        throw new Error(gl.getShaderInfoLog(shader));
      }
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "place");
    gl.bindAttribLocation(program, 1, "normal");
    gl.linkProgram(program);
    return program;
  }

  upload(body) {
    const { gl } = this;
    body.buffers = [body.places, body.normals].map((values) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      return buffer;
    });
    body.arrays = {};
    for (const name of ["triangles", "lines"]) {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      body.buffers.forEach((buffer, i) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        gl.enableVertexAttribArray(i);
        gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
      });
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, body[name], gl.STATIC_DRAW);
      body.arrays[name] = array;
    }
    gl.bindVertexArray(null);
  }

  changed(body) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, body.buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, body.places, gl.STATIC_DRAW);
    gl.bindVertexArray(body.arrays.lines);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, body.lines, gl.DYNAMIC_DRAW);
    gl.bindVertexArray(null);
  }

  begin(background) {
    const { gl, where, state } = this, camera = this.camera();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.useProgram(this.program);
    for (const name of ["centre", "stretch", "right", "up", "towards"]) {
      gl.uniform3fv(where[name], camera[name]);
    }
    gl.uniform2fv(where.scale, camera.scale);
    gl.uniform2fv(where.pan, state.pan);
    gl.uniform1f(where.depth, camera.depth);
    this.cutting(this.cut());
    this.place();
  }

  cutting(plane) {
    this.gl.uniform4fv(this.where.cut, plane);
  }

  moved(i, j) {
    const [x, y] = this.state.pan, { width, height } = this.canvas;
    this.gl.uniform2f(this.where.pan, x + 2 * i / width, y + 2 * j / height);
  }

  part(body, name, colour, shaded, bias) {
    const { gl, where } = this, index = body[name];
    if (!index.length) return;
    gl.uniform3fv(where.shift, body.shift.map((x) => x * this.state.explode));
    gl.uniform3fv(where.colour, colour);
    gl.uniform1i(where.shaded, shaded ? 1 : 0);
    gl.uniform1f(where.bias, bias);
    gl.bindVertexArray(body.arrays[name]);
    gl.drawElements(name === "lines" ? gl.LINES : gl.TRIANGLES, index.length,
      index.BYTES_PER_ELEMENT === 4 ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT, 0);
  }

  // Where more backs than fronts lie behind the plane of the cut, the plane is inside the body.
  section(body, colour) {
    const { gl, plane } = this;
    gl.clear(gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.STENCIL_TEST);
    gl.disable(gl.DEPTH_TEST);
    gl.colorMask(false, false, false, false);
    gl.depthMask(false);
    gl.stencilFunc(gl.ALWAYS, 0, 255);
    gl.stencilOpSeparate(gl.FRONT, gl.KEEP, gl.KEEP, gl.DECR_WRAP);
    gl.stencilOpSeparate(gl.BACK, gl.KEEP, gl.KEEP, gl.INCR_WRAP);
    this.part(body, "triangles", colour, false, 0);
    gl.colorMask(true, true, true, true);
    gl.depthMask(true);
    gl.enable(gl.DEPTH_TEST);
    gl.stencilFunc(gl.NOTEQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
    this.cutting(UNCUT);
    plane.shift = body.shift;
    this.part(plane, "triangles", colour, false, 0);
    this.cutting(this.cut());
    gl.disable(gl.STENCIL_TEST);
  }

  // The row of the body at a pixel, -1 for none: bodies are painted in the colour of their row.
  pick(x, y) {
    const { gl, canvas } = this, { width, height } = canvas;
    const target = gl.createFramebuffer(), made = [];
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    for (const [kind, slot] of [[gl.RGBA8, gl.COLOR_ATTACHMENT0],
      [gl.DEPTH24_STENCIL8, gl.DEPTH_STENCIL_ATTACHMENT]]) {
      const buffer = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, kind, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, slot, gl.RENDERBUFFER, buffer);
      made.push(buffer);
    }
    this.drawRows();
    const pixel = new Uint8Array(4);
    gl.readPixels(x, height - 1 - y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    made.forEach((buffer) => gl.deleteRenderbuffer(buffer));
    gl.deleteFramebuffer(target);
    return pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
  }
}
