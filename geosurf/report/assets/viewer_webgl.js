// Triangles and lines by WebGL 2.

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

class WebGLPainter extends Painter {
  constructor(canvas, bodies, box) {
    super(canvas, bodies, box);
    this.gl = canvas.getContext("webgl2", { antialias: true, stencil: true });
    if (!this.gl) throw new Error("WebGL 2 is missing");
    this.ratio = devicePixelRatio; // pixels of the picture for each of the page
    this.program = this.link();
    this.gl.useProgram(this.program);
    this.where = {};
    for (const name of ["shift", "centre", "stretch", "right", "up", "towards", "scale", "pan",
      "depth", "bias", "colour", "cut", "shaded"]) {
      this.where[name] = this.gl.getUniformLocation(this.program, name);
    }
    for (const body of [...bodies, this.frame, this.plane]) this.upload(body);
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

  finish() {} // the browser shows what is drawn

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
