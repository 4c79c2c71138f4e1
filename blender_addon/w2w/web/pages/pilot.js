// SPDX-License-Identifier: GPL-3.0-or-later
// A pilot: recordings of people held against the map, and stretches of them that are marked over their signals.
import { ask, complain, find, here, make, safely } from "./page.js";

let shown = [], asked = 0; // the recordings as they are drawn; how often files were chosen
const READABLE = /\.(csv|zip|npz)$/i, NOTCH = 0.1;
const WORN = ["worn-folder", "worn-files"];

function form() {
  const found = new FormData(), files = WORN.flatMap((name) => [...find(name).files]).filter((file) => READABLE.test(file.name));
  if (!files.length) throw new Error("Choose a folder or files of recordings first.");
  for (const file of files) {
    const name = (file.webkitRelativePath || file.name).replace(/^[^/]+\/(?=.)/, "");
    if (name !== "labels.csv" || !marked().length) found.append("files", file, name);
  }
  return found;
}

const marked = () => shown.flatMap((one) => one.stretches.map((stretch) => ({ ...stretch, file: one.file, who: one.who.value.trim() })));
const quoted = (cell) => `"${String(cell).replaceAll('"', '""')}"`;

// What is marked, as the csv of times that the command reads.
function labels() {
  const rows = marked();
  if (rows.some((row) => !row.activity)) throw new Error("Say what each marked stretch is.");
  return ["file,activity,subject,start,end", ...rows.map((row) => [row.file, row.activity, row.who, row.start, row.end].map(quoted).join(","))].join("\n");
}

async function hold(redraw) {
  const content = form();
  content.append("at", find("worn-at").value.trim());
  if (marked().length) content.append("labels", new File([labels()], "labels.csv"));
  find("pilot-said").textContent = "Reading …";
  try {
    const found = await ask(here("/pilot"), { method: "POST", body: content });
    const more = [...found.cautions.map((one) => `${one.text}.`), found.next, ...found.skipped.map(left)];
    find("pilot-said").textContent = `${found.sentence} ${more.join(" ")}`;
    redraw();
  } catch (error) { find("pilot-said").textContent = ""; throw error; }
}

const left = ([file, why]) => `Left out: ${file}: ${why}.`;

// The signals of what was chosen, each under its name with who wore it.
async function look() {
  const now = (asked += 1);
  shown = [];
  find("worn").replaceChildren();
  find("pilot-said").textContent = "Reading …";
  try {
    const found = await ask(here("/pilot/signals"), { method: "POST", body: form() });
    if (now !== asked) return;
    shown = found.recordings.map(recording);
    find("worn").replaceChildren(...shown.map((one) => one.item));
    find("pilot-said").textContent = found.skipped.map(left).join(" ");
    shown.forEach(draw);
  } catch (error) { if (now === asked) { find("pilot-said").textContent = ""; throw error; } }
}

function recording({ file, seconds, signal }) {
  const parts = file.split("/"), item = make("li"), who = make("input", "", { type: "text", maxlength: 80 }), head = make("div", "", { class: "fields" }), label = make("label", "Who ");
  const canvas = make("canvas", "", { role: "img", "aria-label": `Acceleration of ${file} over ${seconds} s: drag over a stretch, or add one by its seconds` });
  const list = make("ul", "", { class: "plain" }), add = make("button", "Add a stretch", { type: "button", class: "button" });
  const one = { file, seconds, signal, who, item, canvas, list, stretches: [], drag: null };
  who.value = parts.length > 1 ? parts[parts.length - 2] : parts[0].replace(/\.[^.]*$/, "");
  label.append(who);
  head.append(label);
  add.addEventListener("click", () => mark(one, 0, seconds));
  item.append(make("b", `${file}, ${Math.round(seconds)} s`), head, canvas, list, add);
  const at = (event) => Math.min(Math.max((event.offsetX / canvas.clientWidth) * seconds, 0), seconds);
  canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); one.drag = [at(event), at(event)]; });
  canvas.addEventListener("pointermove", (event) => { if (one.drag) { one.drag[1] = at(event); draw(one); } });
  canvas.addEventListener("pointercancel", () => { one.drag = null; draw(one); });
  canvas.addEventListener("pointerup", () => {
    const [from, to] = (one.drag || [0, 0]).toSorted((a, b) => a - b);
    one.drag = null;
    if (to - from >= NOTCH) mark(one, from, to); else draw(one);
  });
  new ResizeObserver(() => draw(one)).observe(canvas);
  return one;
}

// A stretch is a line of two numbers and an activity; the signal shows where it lies.
function mark(one, from, to) {
  const stretch = { start: Number(from.toFixed(1)), end: Number(to.toFixed(1)), activity: "" }, line = make("li", "", { class: "many" });
  const field = (name, text, more) => {
    const input = make("input", "", { required: "", "aria-label": `${text} in ${one.file}`, ...more });
    input.value = stretch[name];
    input.addEventListener("input", () => { stretch[name] = more.type === "number" ? Number(input.value) : input.value.trim(); draw(one); });
    return input;
  };
  const seconds = { type: "number", min: 0, max: one.seconds, step: NOTCH };
  const activity = field("activity", "Activity", { type: "text", list: "names", maxlength: 80, placeholder: "activity" });
  const gone = make("button", "Remove", { type: "button", class: "button", "aria-label": `Remove the stretch in ${one.file}` });
  gone.addEventListener("click", () => { one.stretches.splice(one.stretches.indexOf(stretch), 1); line.remove(); draw(one); });
  line.append(field("start", "From, s,", seconds), make("span", "to"), field("end", "To, s,", seconds), make("span", "s"), activity, gone);
  one.stretches.push(stretch);
  one.list.append(line);
  activity.focus();
  draw(one);
}

function draw({ canvas, signal, seconds, stretches, drag }) {
  const colour = (name) => getComputedStyle(canvas).getPropertyValue(name), scale = devicePixelRatio || 1;
  canvas.width = canvas.clientWidth * scale;
  canvas.height = canvas.clientHeight * scale;
  const brush = canvas.getContext("2d"), { width, height } = canvas, x = (time) => (time / seconds) * width;
  brush.fillStyle = colour("--fill");
  for (const [from, to] of [...stretches.map((one) => [one.start, one.end]), ...(drag ? [drag] : [])]) brush.fillRect(x(from), 0, x(to) - x(from), height);
  const most = Math.max(...signal.flat().filter((size) => size !== null)), y = (size) => height * (1 - (0.94 * size) / most) - 1;
  brush.fillStyle = colour("--ink");
  signal.forEach((ends, number) => { // a piece that was lost stays empty
    if (ends) brush.fillRect((number / signal.length) * width, y(ends[1]), Math.max(width / signal.length, 1), y(ends[0]) - y(ends[1]) + scale);
  });
}

export function readyPilot(redraw) {
  find("pilot").addEventListener("submit", safely(() => hold(redraw)));
  for (const name of WORN) find(name).addEventListener("change", safely(() => WORN.some((each) => find(each).files.length) ? look() : complain("")));
}
