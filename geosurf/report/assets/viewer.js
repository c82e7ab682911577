// An interactive view of units or surfaces, drawn with WebGL 2 and nothing else.
//
// Parallel projection, as in the pictures. Three steps: `decode` reads the arrays of the page,
// `Painter` draws them, `connect` joins the controls. Numbers are metres until the shader.
"use strict";
(() => {
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
        light = 0.6 + 0.42 * max(dot(n, normalize(vec3(-0.35, 0.65, 0.7))), 0.0);
      }
      paint = vec4(colour * light, 1.0);
    }`;

  const AXES = { easting: 0, northing: 1, elevation: 2 };
  const VIEWS = { southwest: [225, 28], southeast: [135, 28], northwest: [315, 28],
    northeast: [45, 28], south: [180, 0], west: [270, 0], top: [180, 90] };
  const rad = (degrees) => degrees * Math.PI / 180;
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const rgb = (code) => [1, 3, 5].map((i) => parseInt(code.slice(i, i + 2), 16) / 255);
  const grouped = (x) => Math.round(x).toString().replace("-", "\u2212")
    .replace(/\B(?=(\d{3})+$)/g, "\u202f");

  // ---- the arrays of the page ----------------------------------------------------------

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

  // ---- drawing -------------------------------------------------------------------------

  class Painter {
    constructor(canvas, gl, bodies, box) {
      Object.assign(this, { canvas, gl, bodies, box });
      this.program = this.link();
      gl.useProgram(this.program);
      this.where = {};
      for (const name of ["shift", "centre", "stretch", "right", "up", "towards", "scale", "pan",
        "depth", "bias", "colour", "cut", "shaded"]) {
        this.where[name] = gl.getUniformLocation(this.program, name);
      }
      for (const body of bodies) this.upload(body);
      this.frame = { places: new Float32Array(24), triangles: new Uint16Array(0), rgb: [0, 0, 0],
        lines: new Uint16Array([0, 1, 0, 2, 0, 4, 1, 3, 1, 5, 2, 3, 2, 6, 3, 7, 4, 5, 4, 6, 5, 7,
          6, 7]), shift: [0, 0, 0] };
      for (let i = 0; i < 8; i += 1) {
        for (let k = 0; k < 3; k += 1) this.frame.places[3 * i + k] = box[2 * k + (i >> k & 1)];
      }
      this.frame.normals = new Float32Array(24);
      this.upload(this.frame);
      this.plane = { places: new Float32Array(12), normals: new Float32Array(12),
        triangles: new Uint16Array([0, 1, 2, 1, 3, 2]), lines: new Uint16Array(0) };
      this.upload(this.plane);
      this.state = { azimuth: 225, elevation: 28, zoom: 1, pan: [0, 0], explode: 0,
        exaggeration: 1, axis: "", level: 0.5, flip: false, picked: -1 };
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
      gl.uniform4fv(where.cut, this.cut());
      this.place();
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

    // The triangles of a body, and its section where it is cut.
    solid(body, colour, shaded) {
      this.part(body, "triangles", colour, shaded, 0);
      if (body.closed && this.state.axis) this.section(body, colour.map((x) => shaded ? 0.9 * x : x));
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
      gl.uniform4fv(this.where.cut, [0, 0, 0, 1e30]);
      plane.shift = body.shift;
      this.part(plane, "triangles", colour, false, 0);
      gl.uniform4fv(this.where.cut, this.cut());
      gl.disable(gl.STENCIL_TEST);
    }

    // The corners of the plane of the cut, a little larger than the model.
    place() {
      const { gl, box, state, plane } = this, k = AXES[state.axis];
      if (k === undefined) return;
      const [u, v] = [0, 1, 2].filter((axis) => axis !== k);
      for (let i = 0; i < 4; i += 1) {
        plane.places[3 * i + k] = box[2 * k] + state.level * (box[2 * k + 1] - box[2 * k]);
        [u, v].forEach((axis, bit) => {
          const [low, high] = [box[2 * axis], box[2 * axis + 1]], more = 0.01 * (high - low);
          plane.places[3 * i + axis] = i >> bit & 1 ? high + more : low - more;
        });
      }
      gl.bindBuffer(gl.ARRAY_BUFFER, plane.buffers[0]);
      gl.bufferData(gl.ARRAY_BUFFER, plane.places, gl.STATIC_DRAW);
    }

    draw(background, ink) {
      const { gl, state } = this;
      this.begin(background);
      this.bodies.forEach((body, i) => {
        if (!body.shown) return;
        const picked = i === state.picked;
        this.solid(body, body.rgb.map((x) => picked ? 0.45 * x + 0.55 : x), true);
        if (!body.triangles.length) this.thick(body, body.rgb, picked ? 2 : 1);
        else this.part(body, "lines", picked ? [0.78, 0.06, 0.18] : [0.1, 0.11, 0.13], false, 2e-3);
      });
      if (state.explode > 0) return; // an exploded model has no common box
      gl.uniform4fv(this.where.cut, [0, 0, 0, 1e30]);
      this.box_behind(ink);
    }

    // Curves and fault sticks: WebGL draws lines of one pixel, so they are drawn side by side.
    thick(body, colour, width) {
      const { gl, where, canvas } = this, [x, y] = this.state.pan;
      for (const [i, j] of [[0, 0], [width, 0], [-width, 0], [0, width], [0, -width]]) {
        gl.uniform2f(where.pan, x + 2 * i / canvas.width, y + 2 * j / canvas.height);
        this.part(body, "lines", colour, false, 3e-3);
      }
      gl.uniform2f(where.pan, x, y);
    }

    // The edges of the box, except those at the corner next to the viewer.
    box_behind(ink) {
      const { gl, frame } = this, all = frame.lines;
      const nearest = this.camera().towards.reduce((row, x, k) => row | (x > 1e-6) << k, 0);
      const behind = [];
      for (let i = 0; i < all.length; i += 2) {
        if (all[i] !== nearest && all[i + 1] !== nearest) behind.push(all[i], all[i + 1]);
      }
      gl.bindVertexArray(frame.arrays.lines);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(behind), gl.DYNAMIC_DRAW);
      this.part({ ...frame, lines: behind }, "lines", ink, false, 0);
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
      this.begin([0, 0, 0]);
      this.bodies.forEach((body, i) => {
        const row = i + 1;
        const code = [row & 255, row >> 8 & 255, row >> 16].map((v) => v / 255);
        if (!body.shown) return;
        this.solid(body, code, false);
        if (!body.triangles.length) this.thick(body, code, 3); // easier to hit
      });
      const pixel = new Uint8Array(4);
      gl.readPixels(x, height - 1 - y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      made.forEach((buffer) => gl.deleteRenderbuffer(buffer));
      gl.deleteFramebuffer(target);
      return pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
    }
  }

  // ---- controls ------------------------------------------------------------------------

  function connect(root) {
    const head = JSON.parse(root.querySelector(".view3d-head").textContent);
    const canvas = root.querySelector("canvas");
    const gl = canvas.getContext("webgl2", { antialias: true, stencil: true });
    if (!gl) return; // the still picture and the words below it stay
    root.classList.add("ready");
    const bodies = decode(head, root.querySelector(".view3d-data").textContent);
    const painter = new Painter(canvas, gl, bodies, head.box), { state } = painter;
    state.exaggeration = head.exaggeration;
    state.explode = head.explode;
    const find = (name) => root.querySelector(`[data-do=${name}]`);

    function draw() {
      const size = [canvas.clientWidth, canvas.clientHeight];
      const [width, height] = size.map((n) => Math.max(1, Math.round(n * devicePixelRatio)));
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      const style = getComputedStyle(root);
      const colour = (name) => rgb(style.getPropertyValue(name).trim());
      painter.draw(colour("--paper"), colour("--faint"));
      compass();
    }
    let waiting = false;
    function redraw() {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => { waiting = false; draw(); });
    }

    function compass() {
      const { right, up } = painter.camera();
      for (const [name, axis] of [["e", 0], ["n", 1], ["up", 2]]) {
        const [x, y] = [22 * right[axis], -22 * up[axis]];
        const line = root.querySelector(`.compass .${name}`), mark = line.nextElementSibling;
        line.setAttribute("x2", x);
        line.setAttribute("y2", y);
        mark.setAttribute("x", 1.45 * x);
        mark.setAttribute("y", 1.45 * y);
        line.style.opacity = mark.style.opacity = Math.hypot(x, y) < 5 ? 0 : 1;
      }
    }

    // What a slider says, in words.
    function words() {
      find("exaggeration-words").textContent = `${state.exaggeration}\u00d7`;
      find("explode-words").textContent = `${Math.round(100 * state.explode)} %`;
      const k = AXES[state.axis], low = head.box[2 * k], high = head.box[2 * k + 1];
      find("level-words").textContent = state.axis
        ? `${grouped(head.lower[k] + low + state.level * (high - low))} m` : "";
      find("level").disabled = find("flip").disabled = !state.axis;
    }

    function choose(row) {
      state.picked = row;
      const list = find("facts"), body = bodies[row];
      list.replaceChildren();
      find("name").textContent = body ? body.name : "Click a body, or its name, for its numbers.";
      for (const [key, value] of body ? body.facts : []) {
        const term = document.createElement("dt"), detail = document.createElement("dd");
        term.textContent = key;
        detail.textContent = value;
        list.append(term, detail);
      }
      root.querySelectorAll(".view3d-list button").forEach((button) =>
        button.setAttribute("aria-pressed", String(Number(button.value) === row)));
      redraw();
    }

    function show(rows, on) {
      rows.forEach((i) => { bodies[i].shown = on; });
      root.querySelectorAll("[data-row]").forEach((box) => {
        box.checked = bodies[Number(box.dataset.row)].shown;
      });
      root.querySelectorAll("[data-group]").forEach((box) => {
        const of = bodies.filter((body) => body.group === box.dataset.group);
        const n = of.filter((body) => body.shown).length;
        box.checked = n > 0;
        box.indeterminate = n > 0 && n < of.length;
      });
      redraw();
    }

    function list() {
      const target = root.querySelector(".view3d-list");
      for (const group of new Set(bodies.map((body) => body.group))) {
        const rows = bodies.map((_, i) => i).filter((i) => bodies[i].group === group);
        const fold = document.createElement("details"), summary = document.createElement("summary");
        fold.open = rows.length <= 12;
        const all = document.createElement("input");
        Object.assign(all, { type: "checkbox", checked: true, ariaLabel: `Show ${group}` });
        all.dataset.group = group;
        all.addEventListener("change", () => show(rows, all.checked));
        summary.append(all, `${group} (${rows.length})`);
        fold.append(summary);
        for (const i of rows) fold.append(item(i));
        target.append(fold);
      }
    }

    function item(i) {
      const row = document.createElement("div"), box = document.createElement("input");
      const button = document.createElement("button"), patch = document.createElement("i");
      Object.assign(box, { type: "checkbox", checked: true, ariaLabel: `Show ${bodies[i].name}` });
      box.dataset.row = i;
      box.addEventListener("change", () => show([i], box.checked));
      patch.style.background = bodies[i].colour;
      Object.assign(button, { type: "button", value: i });
      button.append(patch, bodies[i].name);
      button.addEventListener("click", () => choose(state.picked === i ? -1 : i));
      row.append(box, button);
      return row;
    }

    const everything = bodies.map((_, i) => i);
    const number = (name) => (event) => { state[name] = Number(event.target.value); };
    const actions = {
      all: ["click", () => show(everything, true)],
      none: ["click", () => show(everything, false)],
      explode: ["input", number("explode")],
      exaggeration: ["input", number("exaggeration")],
      level: ["input", number("level")],
      axis: ["change", (event) => { open(event.target.value); }],
      flip: ["change", (event) => { state.flip = event.target.checked; }],
      view: ["change", (event) => turn(event.target.value)],
      save: ["click", save],
      wide: ["click", () => document.fullscreenElement
        ? document.exitFullscreen() : root.requestFullscreen().catch(() => {})],
    };
    for (const [name, [event, act]] of Object.entries(actions)) {
      find(name).addEventListener(event, (happened) => { act(happened); words(); redraw(); });
    }
    function open(axis) { // the side towards the viewer is taken away
      state.axis = axis;
      state.flip = axis !== "" && painter.camera().towards[AXES[axis]] < 0;
      find("flip").checked = state.flip;
    }
    function turn(view) {
      [state.azimuth, state.elevation] = VIEWS[view];
      Object.assign(state, { zoom: 1, pan: [0, 0] });
    }
    function save() {
      draw();
      const link = document.createElement("a");
      Object.assign(link, { download: "view.png", href: canvas.toDataURL("image/png") });
      link.click();
    }

    // Drag turns, drag with Shift or the right button moves, two fingers or the wheel zoom.
    const down = new Map();
    let still = true, gap = 0;
    const apart = () => {
      const [a, b] = [...down.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    function orbit(dx, dy) {
      state.azimuth = (state.azimuth + 0.4 * dx + 360) % 360;
      state.elevation = Math.max(-90, Math.min(90, state.elevation + 0.4 * dy));
    }
    function zoom(by, x, y) {
      const before = state.zoom;
      state.zoom = Math.max(0.3, Math.min(60, before * by));
      const here = [2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight];
      state.pan = state.pan.map((p, k) => here[k] + (p - here[k]) * state.zoom / before);
    }
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      down.set(event.pointerId, { x: event.clientX, y: event.clientY });
      still = down.size === 1;
      if (down.size === 2) gap = apart();
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = down.get(event.pointerId);
      if (!last) return;
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      if (still && Math.hypot(dx, dy) < 3) return; // a click, so far
      still = false;
      down.set(event.pointerId, { x: event.clientX, y: event.clientY });
      const place = canvas.getBoundingClientRect();
      if (down.size === 2) {
        zoom(apart() / gap, event.clientX - place.left, event.clientY - place.top);
        gap = apart();
      } else if (event.shiftKey || event.buttons === 2) {
        state.pan[0] += 2 * dx / canvas.clientWidth;
        state.pan[1] -= 2 * dy / canvas.clientHeight;
      } else {
        orbit(dx, dy);
      }
      redraw();
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => {
        const mine = down.delete(event.pointerId);
        if (!mine || !still || name === "pointercancel" || event.button) return;
        const place = canvas.getBoundingClientRect(), by = canvas.width / place.width;
        choose(painter.pick(Math.round((event.clientX - place.left) * by),
          Math.round((event.clientY - place.top) * by)));
      });
    }
    canvas.addEventListener("wheel", (event) => {
      // a page that is scrolled past the view goes on scrolling: click into it first
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      zoom(Math.exp(-0.0015 * event.deltaY), event.offsetX, event.offsetY);
      redraw();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
      const keys = { ArrowLeft: () => orbit(-12, 0), ArrowRight: () => orbit(12, 0),
        ArrowUp: () => orbit(0, 12), ArrowDown: () => orbit(0, -12),
        "+": () => zoom(1.2, ...middle), "-": () => zoom(1 / 1.2, ...middle),
        "0": () => turn(find("view").value), Escape: () => choose(-1) };
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
      redraw();
    });
    canvas.addEventListener("webglcontextlost", () => root.classList.remove("ready"));

    find("explode").value = state.explode;
    find("exaggeration").value = state.exaggeration;
    list();
    show(everything.filter((i) => !bodies[i].on), false);
    choose(-1);
    words();
    new ResizeObserver(redraw).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
    root.view = { draw, painter, choose };
    draw();
  }

  document.querySelectorAll(".view3d").forEach((root) => {
    try {
      connect(root);
    } catch (error) {
      root.classList.remove("ready");
      console.error(error);
    }
  });
})();
