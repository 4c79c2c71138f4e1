// SPDX-License-Identifier: GPL-3.0-or-later
// The body in 3D: draws it coloured by a value a vertex, and tells which patch lies under a point.
"use strict";

const ARRAYS = { uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array };
const FIELD = Math.tan((14 * Math.PI) / 180); // half the view's opening: nearly parallel, as in the pictures
const LIMIT = 1.5; // radians that the eye may rise or sink

function unpack({ type, data }) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  return new ARRAYS[type](bytes.buffer);
}

const VERTEX = `#version 300 es
uniform mat4 camera;
in vec3 position, normal;
in float value;
in uint cell;
out vec3 facing;
out float share;
flat out uint owner;
void main() {
  facing = normal; share = value; owner = cell;
  gl_Position = camera * vec4(position, 1.0);
}`;

const SHADED = `#version 300 es
precision highp float;
uniform sampler2D colours;
uniform vec3 eye;
in vec3 facing;
in float share;
out vec4 colour;
void main() {
  vec3 n = normalize(facing);
  // light from the eye and a little from above: form shows, and colours stay those of the scale
  float light = 0.7 + 0.28 * max(dot(n, eye), 0.0) + 0.05 * n.z;
  colour = vec4(texture(colours, vec2(share, 0.5)).rgb * light, 1.0);
}`;

const PATCHES = `#version 300 es
precision highp float;
flat in uint owner;
in vec3 facing;
out vec4 colour;
void main() {
  uint number = owner + 1u;
  colour = vec4(float(number & 255u), float((number >> 8) & 255u), float((number >> 16) & 255u), 255.0) / 255.0;
}`;

class Viewer {
  constructor(canvas, data) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("no WebGL 2");
    this.gl = gl;
    const steps = unpack(data.positions);
    this.positions = Float32Array.from(steps, (value, i) => data.corner[i % 3] + value * data.step);
    const faces = Uint32Array.from(unpack(data.faces));
    this.normals = vertexNormals(this.positions, faces);
    this.cells = Uint32Array.from(unpack(data.cells));
    this.count = faces.length;
    this.shaded = program(gl, VERTEX, SHADED);
    this.patches = program(gl, VERTEX, PATCHES);
    this.buffer("position", this.positions, 3);
    this.buffer("normal", this.normals, 3);
    this.values = this.buffer("value", new Float32Array(this.positions.length / 3), 1);
    this.buffer("cell", this.cells, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    const table = unpack(data.colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, table.length / 3, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, table);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.enable(gl.DEPTH_TEST);
    this.target = gl.createFramebuffer();
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    this.positions.forEach((value, i) => {
      low[i % 3] = Math.min(low[i % 3], value);
      high[i % 3] = Math.max(high[i % 3], value);
    });
    this.middle = low.map((value, axis) => (value + high[axis]) / 2);
    this.size = low.map((value, axis) => high[axis] - value);
    this.home();
    this.onDraw = () => {};
    this.waiting = false;
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  buffer(name, values, size) {
    const { gl } = this, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    const location = ATTRIBUTES.indexOf(name);
    gl.enableVertexAttribArray(location);
    if (values instanceof Uint32Array) gl.vertexAttribIPointer(location, size, gl.UNSIGNED_INT, 0, 0);
    else gl.vertexAttribPointer(location, size, gl.FLOAT, false, 0, 0);
    return buffer;
  }

  // Shares of the colour scale, 0 to 1, one a vertex.
  paint(shares) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.values);
    gl.bufferData(gl.ARRAY_BUFFER, shares, gl.DYNAMIC_DRAW);
    this.redraw();
  }

  home() { this.yaw = 0; this.pitch = 0.06; this.zoom = 1; this.focus = this.middle; this.redraw(); }

  // The whole body, turned by so many radians.
  open(yaw) { this.yaw = yaw; this.draw(); }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-LIMIT, Math.min(LIMIT, this.pitch + pitch));
    this.redraw();
  }

  // Coming closer from afar goes towards a vertex.
  towards(vertex) {
    if (this.zoom <= 1.05) this.focus = this.positions.slice(3 * vertex, 3 * vertex + 3);
  }

  closer(factor) { this.zoom = Math.max(0.7, Math.min(8, this.zoom * factor)); this.redraw(); }

  // Turn until a vertex's skin looks at the eye.
  face(vertex) {
    this.focus = this.positions.slice(3 * vertex, 3 * vertex + 3);
    const [x, y, z] = this.normals.subarray(3 * vertex, 3 * vertex + 3);
    this.yaw = Math.hypot(x, y) > 0.2 ? Math.atan2(x, -y) : this.yaw;
    this.pitch = Math.max(-0.6, Math.min(0.9, Math.asin(Math.max(-1, Math.min(1, z))) * 0.7));
    this.redraw();
  }

  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  camera() {
    const aspect = this.canvas.width / this.canvas.height;
    const eye = [Math.sin(this.yaw) * Math.cos(this.pitch), -Math.cos(this.yaw) * Math.cos(this.pitch), Math.sin(this.pitch)];
    const right = [Math.cos(this.yaw), Math.sin(this.yaw), 0];
    const up = cross(eye, right);
    const half = Math.max(this.size[2] / 2, Math.max(this.size[0], this.size[1]) / 2 / aspect) * 1.06;
    const distance = half / FIELD / this.zoom + (this.zoom > 1 ? 0 : this.size[1] / 2);
    const nearer = Math.max(0, 1 - 1 / this.zoom);
    const centre = this.middle.map((value, axis) => value + nearer * (this.focus[axis] - value));
    const near = Math.max(0.02, distance - 2), far = distance + 2;
    const rows = [right, up, eye].map((axis) => [...axis, -dot(axis, centre)]);
    rows[2][3] -= distance;
    const a = 1 / (FIELD * aspect), b = 1 / FIELD;
    const c = (far + near) / (near - far), d = (2 * far * near) / (near - far);
    const lines = [rows[0].map((v) => a * v), rows[1].map((v) => b * v), rows[2].map((v) => c * v), rows[2].map((v) => -v)];
    lines[2][3] += d;
    const matrix = new Float32Array(16);
    lines.forEach((line, row) => line.forEach((value, column) => { matrix[4 * column + row] = value; }));
    return { matrix, eye };
  }

  // As large as it is shown, or as given: CSS pixels, and the canvas's own to each.
  draw(shownWidth = this.canvas.clientWidth, shownHeight = this.canvas.clientHeight, ratio = Math.min(window.devicePixelRatio || 1, 2)) {
    const { gl, canvas } = this;
    [this.width, this.height] = [shownWidth, shownHeight];
    const width = Math.max(1, Math.round(shownWidth * ratio)), height = Math.max(1, Math.round(shownHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const view = this.camera();
    this.view = view;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    this.pass(this.shaded, view);
    this.stale = true;
    this.onDraw();
  }

  pass(drawn, view) {
    const { gl } = this;
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(drawn);
    gl.uniformMatrix4fv(gl.getUniformLocation(drawn, "camera"), false, view.matrix);
    gl.uniform3fv(gl.getUniformLocation(drawn, "eye"), view.eye);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }

  // The patch under a point of the canvas (CSS pixels from its top left), or -1.
  patchAt(x, y) {
    const { gl, canvas } = this;
    if (!this.view) return -1;
    const { width, height } = canvas;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    if (this.stale) {
      if (this.picture) { gl.deleteRenderbuffer(this.picture); gl.deleteRenderbuffer(this.depth); }
      this.picture = attach(gl, gl.RGBA8, gl.COLOR_ATTACHMENT0, width, height);
      this.depth = attach(gl, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT, width, height);
      gl.viewport(0, 0, width, height);
      this.pass(this.patches, this.view);
      this.stale = false;
    }
    const pixel = new Uint8Array(4);
    const column = Math.floor((x * width) / this.width), row = height - 1 - Math.floor((y * height) / this.height);
    gl.readPixels(column, row, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
  }

  // Where a vertex is on the canvas, CSS pixels from its top left.
  project(vertex) {
    const p = this.positions.subarray(3 * vertex, 3 * vertex + 3), m = this.view.matrix;
    const [x, y, , w] = [0, 1, 2, 3].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
    return [((x / w + 1) / 2) * this.width, ((1 - y / w) / 2) * this.height];
  }

  apart(one, other) {
    return Math.hypot(...[0, 1, 2].map((axis) => this.positions[3 * one + axis] - this.positions[3 * other + axis]));
  }
}

const ATTRIBUTES = ["position", "normal", "value", "cell"];

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  ATTRIBUTES.forEach((name, location) => gl.bindAttribLocation(made, location, name));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  return made;
}

function attach(gl, format, point, width, height) {
  const buffer = gl.createRenderbuffer();
  gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
  gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, point, gl.RENDERBUFFER, buffer);
  return buffer;
}

function vertexNormals(positions, faces) {
  const normals = new Float32Array(positions.length);
  const point = (vertex) => positions.subarray(3 * vertex, 3 * vertex + 3);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => point(faces[i + corner]));
    const normal = cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
    for (let corner = 0; corner < 3; corner++)
      for (let axis = 0; axis < 3; axis++) normals[3 * faces[i + corner] + axis] += normal[axis];
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) normals[i + axis] /= length;
  }
  return normals;
}

function cross(a, b) { return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; }

function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
