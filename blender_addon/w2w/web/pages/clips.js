// SPDX-License-Identifier: GPL-3.0-or-later
// The table of clips: what each holds and is, saved as it is typed.
import { count, find, here, make, page, safely, saver, send } from "./page.js";
import { figure, forget } from "./figures.js";

const picked = new Set(), before = [];
let touched = false;

const labels = saver("/labels", () => page.study.table.map((row) => ({ file: row.file, activity: row.use ? row.activity || "" : "", subject: row.subject || "" })), (found) => {
  page.study.stale = found.stale;
  page.showStale();
});
export const flushLabels = () => labels.flush();
export const labelsWait = () => labels.busy;

const snapshot = () => page.study.table.map(({ file, activity, subject, use }) => ({ file, activity, subject, use }));

// Does a change of the table that can be undone.
function change(work) {
  before.push(snapshot());
  work();
  find("undo").hidden = false;
  labels.soon();
}

function undo() {
  const rows = new Map((before.pop() || []).map((row) => [row.file, row]));
  for (const row of page.study.table) Object.assign(row, rows.get(row.file) || {});
  find("undo").hidden = !before.length;
  labels.soon();
  drawClips();
}

function held(row) {
  const facts = row.judged;
  if (!facts) return ["being looked at …", ""];
  if (facts.problem) return [`cannot be used: ${facts.problem}`, "caution"];
  const up = facts.up ? `, ${facts.up} up` : "", cut = facts.cut ? `; left out: ${facts.cut}` : "", copy = row.copy_of ? `; the same file as ${row.copy_of}` : "";
  return [`${facts.duration_s.toFixed(1)} s at ${Math.round(facts.frame_rate)} frames/s${up}${cut}${copy}`, row.copy_of ? "caution" : ""];
}

function box(row, name, more = {}) {
  const input = make("input", "", { type: "text", maxlength: 80, "aria-label": `${name} of ${row.name}`, placeholder: name, title: row[name] || "", ...more });
  input.value = row[name] || "";
  input.addEventListener("change", () => {
    change(() => { row[name] = input.value.trim(); if (name === "activity" && row[name]) row.use = true; });
    setTimeout(drawClips); // when the next field has the focus
  });
  return input;
}

function line(row) {
  const shown = make("tr"), [text, kind] = held(row), use = make("input", "", { type: "checkbox", "aria-label": `Use ${row.name}` });
  const pick = make("button", "", { type: "button", class: "pick", "aria-pressed": String(picked.has(row.file)), "aria-label": `Pick ${row.name}` });
  use.checked = row.use;
  shown.className = row.use ? "" : "out";
  use.addEventListener("change", () => { change(() => { row.use = use.checked; }); setTimeout(drawClips); });
  pick.addEventListener("click", (event) => choose(row, event.shiftKey));
  if (row.judged && !row.judged.problem) pick.append(figure(row.file));
  const name = make("td", "", { class: "file" });
  name.append(make("span", row.name), make("small", text, { class: kind }));
  const cells = [make("td"), name, make("td"), make("td"), make("td")];
  cells[0].append(pick);
  cells[2].append(box(row, "activity", { list: "names" }));
  cells[3].append(box(row, "subject"));
  cells[4].append(use);
  shown.append(...cells);
  return shown;
}

const bad = (row) => Boolean(row.judged && row.judged.problem);

// Draws the table anew; whoever types stays where they are.
export function drawClips() {
  const inputs = () => [...find("label").querySelectorAll("input, .pick")], at = inputs().indexOf(document.activeElement);
  for (const row of page.study.table) row.use = row.use ?? Boolean(row.activity);
  const good = page.study.table.filter((row) => !bad(row)), others = page.study.table.filter(bad);
  const lines = good.map(line);
  if (others.length) {
    const heading = make("tr", "", { class: "heading" });
    heading.append(make("th", `${count(others.length, "file")} that cannot be used`, { colspan: 5, scope: "colgroup" }));
    lines.push(heading, ...others.map(line));
  }
  forget();
  find("clips").replaceChildren(...lines);
  find("clips").querySelectorAll("canvas").forEach((canvas) => canvas.replaceWith(figure(canvas.dataset.file)));
  activities();
  many();
  if (at >= 0 && inputs()[at]) inputs()[at].focus();
}

let lastPicked = "";

function choose(row, range) {
  const files = page.study.table.map((one) => one.file), from = files.indexOf(lastPicked), to = files.indexOf(row.file);
  const some = range && from >= 0 ? files.slice(Math.min(from, to), Math.max(from, to) + 1) : [row.file], on = !picked.has(row.file);
  for (const file of some) if (on) picked.add(file); else picked.delete(file);
  lastPicked = row.file;
  drawClips();
}

function many() {
  for (const file of [...picked]) if (!page.study.table.some((row) => row.file === file)) picked.delete(file);
  find("many").hidden = !picked.size;
  find("many-count").textContent = `${count(picked.size, "clip")} picked`;
}

// The activities with their numbers of clips, each to be renamed: those of one clip in its row.
function activities() {
  const counts = counted(), names = [...counts.keys()].sort();
  find("names").replaceChildren(...names.map((name) => make("option", "", { value: name })));
  find("activities").replaceChildren(...names.filter((name) => counts.get(name) > 1).map((name) => {
    const label = make("label", count(counts.get(name), "clip")), input = make("input", "", { type: "text", list: "names", maxlength: 80, "aria-label": `New name of ${name}`, title: name });
    input.value = name;
    input.addEventListener("change", () => {
      const to = input.value.trim();
      if (to) change(() => { for (const row of page.study.table) if (row.activity === name) row.activity = to; });
      setTimeout(drawClips);
    });
    label.append(input);
    return label;
  }));
  guess(counts);
  page.showReady(names.map((name) => [name, counts.get(name)]));
}

export function counted() {
  const counts = new Map();
  for (const row of page.study.table) if (row.use && row.activity && !bad(row)) counts.set(row.activity, (counts.get(row.activity) || 0) + 1);
  return counts;
}

export const people = () => new Set(page.study.table.filter((row) => row.use && row.subject && !bad(row)).map((row) => row.subject));

// What a file's name says without the number of its take: Walking (2), walk_03, X Bot@Walking take 4.
function stem(name) {
  let text = name.split("/").pop().replace(/\.[^.]*$/, "").split("@").pop(), was;
  do { was = text; text = text.replace(/([\s_.-]*\(\d+\)|[\s_.-]*(?:take|trial|rep|clip|copy|no|nr)?[\s_.-]*\d+)$/i, "").trim(); } while (text && text !== was);
  return plain(text || was);
}

const plain = (text) => text.toLowerCase().replace(/[\s_-]+/g, "_").replace(/^_|_$/g, "");
const folder = (row) => row.name.split("/").at(-2) || "";

// Many loose files are grouped by their names if asked; so are files of the same names in folders that look like people.
function guess(counts) {
  const used = page.study.table.filter((row) => row.use && row.activity && !bad(row)), folders = new Map();
  for (const row of used) folders.set(stem(row.name), (folders.get(stem(row.name)) || new Set()).add(folder(row)));
  const shared = [...folders.values()].filter((names) => names.size > 1).length;
  const persons = shared > 1 && 2 * shared > folders.size && used.every((row) => plain(folder(row)) === row.activity);
  const loose = persons ? used : used.filter((row) => counts.get(row.activity) === 1), groups = new Set(loose.map((row) => stem(row.name)));
  const worth = !touched && loose.length > 3 && (persons || (loose.length > counts.size / 2 && groups.size * 1.5 < loose.length));
  const listed = (names) => `${names.slice(0, 4).join(", ")}${names.length > 4 ? " …" : ""}`;
  const said = persons ? `${listed([...counts.keys()])} hold clips of the same names. If they are people, the activities are ${groups.size}` : `${loose.length} activities have one clip. By their names without numbers they are ${groups.size}`;
  find("guess-part").hidden = !worth;
  find("guess-text").textContent = worth ? `${said}: ${listed([...groups])}.` : "";
  find("guess").onclick = () => { touched = true; change(() => { for (const row of loose) Object.assign(row, { activity: stem(row.name), subject: row.subject || (persons ? folder(row) : "") }); }); drawClips(); };
}

export function readyClips() {
  find("undo").addEventListener("click", undo);
  find("many").addEventListener("submit", safely(() => {
    const name = find("many-name").value.trim();
    if (!name) return;
    change(() => { for (const row of page.study.table) if (picked.has(row.file)) Object.assign(row, { activity: name, use: true }); });
    picked.clear();
    find("many-name").value = "";
    drawClips();
  }));
  find("many-none").addEventListener("click", () => { picked.clear(); drawClips(); });
  find("many-gone").addEventListener("click", safely(async () => {
    if (!confirm(`Remove ${count(picked.size, "clip")} from the server?`)) return;
    await labels.flush();
    await send(here("/remove"), [...picked]);
    before.length = 0;
    find("undo").hidden = true;
    await page.refresh();
  }));
}
