// SPDX-License-Identifier: GPL-3.0-or-later
// Small pictures that move: the skeleton of a clip, and the body of the demo's answer.
import { ask, find, here, make } from "./page.js";

const PARENTS = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19];
const STILL = matchMedia("(prefers-reduced-motion: reduce)");
const FRAME_MS = 90;
const known = new Map(), seen = new Set();

const ink = () => getComputedStyle(document.documentElement).getPropertyValue("--ink");
const accent = () => getComputedStyle(document.documentElement).getPropertyValue("--accent");

function draw(canvas, frames, at) {
  const brush = canvas.getContext("2d"), points = frames[at % frames.length], scale = canvas.height / 196;
  const place = (joint) => {
    const [x, y, z] = points.slice(3 * joint, 3 * joint + 3);
    return [canvas.width / 2 + scale * (0.85 * x - 0.5 * y), canvas.height - scale * (z + 10)];
  };
  brush.clearRect(0, 0, canvas.width, canvas.height);
  brush.lineWidth = 4.5 * scale * 2;
  brush.lineCap = "round";
  for (let joint = 1; joint < PARENTS.length; joint += 1) {
    const [x, y] = place(joint), [u, v] = place(PARENTS[joint]);
    brush.strokeStyle = [1, 4, 7, 10, 13, 16, 18, 20].includes(joint) ? accent() : ink();
    brush.beginPath();
    brush.moveTo(u, v);
    brush.lineTo(x, y);
    brush.stroke();
  }
  const [x, y] = place(15);
  brush.fillStyle = ink();
  brush.beginPath();
  brush.arc(x, y - 6 * scale, 11 * scale, 0, 7);
  brush.fill();
}

let turn = 0, last = 0, running = false;

function frame(now) {
  if (now - last > FRAME_MS) {
    last = now;
    turn += 1;
    for (const canvas of seen) if (canvas.isConnected && canvas.frames) draw(canvas, canvas.frames, STILL.matches ? 0 : turn);
  }
  running = seen.size > 0 && !document.hidden;
  if (running) requestAnimationFrame(frame);
}

function wake() {
  if (!running && !document.hidden) { running = true; requestAnimationFrame(frame); }
}
document.addEventListener("visibilitychange", wake);

const watcher = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (!isIntersecting) { seen.delete(target); continue; }
    seen.add(target);
    const file = target.dataset.file;
    if (!known.has(file)) known.set(file, ask(here(`/figure?file=${encodeURIComponent(file)}`)).catch(() => null));
    known.get(file).then((frames) => { target.frames = frames; wake(); });
  }
});

// A canvas with a clip's moving skeleton, once the clip was looked at and for as long as it is in sight.
export function figure(file) {
  const canvas = make("canvas", "", { width: 72, height: 84, "aria-hidden": "true" });
  canvas.dataset.file = file;
  watcher.observe(canvas);
  return canvas;
}

export function forget() {
  watcher.disconnect();
  seen.clear();
}

// The body of the demo, turning; its corners are coloured by F1, and products have numbers.
export async function turningBody() {
  const data = await fetch("/static/demo.json").then((reply) => reply.json()).catch(() => null);
  if (!data) return;
  find("demo-title").textContent = data.sentence;
  find("demo-of").textContent = `From ${data.clips} clips of ${data.activities.length} gestures`;
  find("demo-bars").replaceChildren(...data.products.map((product, number) => {
    const line = make("li"), bar = make("meter", "", { min: 0, max: 1, value: product.f1, "aria-hidden": "true" });
    line.append(make("span", String(number + 1), { class: "disc" }), make("span", product.name), bar, make("b", product.f1.toFixed(2)));
    return line;
  }));
  const canvas = find("body"), brush = canvas.getContext("2d"), { places, faces, share, colours } = data;
  const corners = places.length / 3, flat = new Float32Array(3 * corners);
  const paint = (angle) => {
    const cos = Math.cos(angle), sin = Math.sin(angle), scale = canvas.height / 186;
    for (let n = 0; n < corners; n += 1) {
      const x = places[3 * n], y = places[3 * n + 1];
      flat.set([canvas.width / 2 + scale * (x * cos - y * sin), canvas.height - scale * (places[3 * n + 2] + 6 - places.low), x * sin + y * cos], 3 * n);
    }
    brush.clearRect(0, 0, canvas.width, canvas.height);
    const order = [];
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
      const facing = (flat[b] - flat[a]) * (flat[c + 1] - flat[a + 1]) - (flat[c] - flat[a]) * (flat[b + 1] - flat[a + 1]);
      if (facing < 0) order.push([flat[a + 2] + flat[b + 2] + flat[c + 2], f, facing]);
    }
    order.sort((one, other) => other[0] - one[0]);
    for (const [, f] of order) {
      const three = [faces[f], faces[f + 1], faces[f + 2]], [p, q, r] = three.map((n) => [places[3 * n], places[3 * n + 1], places[3 * n + 2]]);
      const mean = Math.round(three.reduce((sum, n) => sum + share[n], 0) / 30), light = lightOn(p, q, r, cos, sin);
      brush.fillStyle = brush.strokeStyle = `rgb(${colours[mean].map((value) => Math.round(value * light)).join()})`;
      brush.beginPath();
      for (const n of three) brush.lineTo(flat[3 * n], flat[3 * n + 1]);
      brush.closePath();
      brush.fill();
      brush.stroke();
    }
    data.products.forEach((product, number) => {
      const n = 3 * product.patch;
      badge(brush, flat[n], flat[n + 1], number + 1, flat[n + 2] > 6 ? 0.25 : 1);
    });
  };
  places.low = places.reduce((low, value, at) => (at % 3 === 2 ? Math.min(low, value) : low), 1e9);
  const step = (now) => {
    if (find("home").hidden) return;
    paint(0.35 + now / 4200);
    if (!STILL.matches) requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

function lightOn(p, q, r, cos, sin) {
  const u = [0, 1, 2].map((at) => q[at] - p[at]), v = [0, 1, 2].map((at) => r[at] - p[at]);
  const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...normal) || 1, towards = -(normal[0] * sin + normal[1] * cos) / length, up = normal[2] / length;
  return Math.min(1.12, 0.62 + 0.4 * Math.max(0, towards) + 0.14 * up);
}

function badge(brush, x, y, text, alpha) {
  brush.globalAlpha = alpha;
  brush.fillStyle = "#fff";
  brush.strokeStyle = "#1b2430";
  brush.lineWidth = 2;
  brush.beginPath();
  brush.arc(x, y, 13, 0, 7);
  brush.fill();
  brush.stroke();
  brush.fillStyle = "#1b2430";
  brush.font = "bold 15px sans-serif";
  brush.textAlign = "center";
  brush.textBaseline = "middle";
  brush.fillText(text, x, y + 1);
  brush.globalAlpha = 1;
  brush.lineWidth = 1;
}
