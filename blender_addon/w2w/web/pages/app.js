// SPDX-License-Identifier: GPL-3.0-or-later
// The app's page: from clips to the answer.
import { ask, complain, count, find, here, make, page, safely, saver, send } from "./page.js";
import { inFolder, upload } from "./uploads.js";
import { counted, drawClips, flushLabels, labelsWait, people, readyClips } from "./clips.js";
import { chips, drawAnswer, fill, readyAnswer, wishes } from "./answer.js";
import { turningBody } from "./figures.js";

const BUSY = ["queued", "running"], AGAIN_MS = 3000;
let listening = null, told = "", answered = "";

const asked = saver("/parameters", parameters, (found) => {
  page.study.stale = found.stale;
  page.showStale();
});

async function begin(content) {
  page.id = (await send("/studies", content)).id;
  history.pushState(null, "", `/studies/${page.id}`);
}

// All that the form asks for: what is cleared is taken back, and what it has no field for stays.
function parameters() {
  const form = find("ask"), given = wishes(form), before = page.study.parameters;
  for (const name of ["patches", "seed"]) if (name in before) given[name] = before[name];
  for (const name of ["title", "sensor"]) if (form.elements[name].value.trim()) given[name] = form.elements[name].value.trim();
  if (form.elements.by_subject.checked || "by_subject" in before) given.by_subject = form.elements.by_subject.checked;
  page.study.parameters = given;
  return given;
}

function fillAsked() {
  const form = find("ask"), given = page.study.parameters;
  fill(form, given);
  for (const name of ["title", "sensor"]) form.elements[name].value = given[name] ?? "";
}

async function run() {
  await flushLabels();
  await asked.flush();
  show(await send(here("/run"), parameters()));
  listen();
}

// News of the run. Behind a proxy a server that starts again looks like a refusal: it is asked again.
function listen() {
  if (listening) listening.close();
  listening = new EventSource(`/api${here("/events")}`);
  listening.onmessage = (event) => {
    const now = JSON.parse(event.data);
    show(now);
    if (!BUSY.includes(now.state)) { listening.close(); page.refresh().catch((error) => complain(error.message)); }
  };
  listening.onerror = () => {
    if (listening.readyState !== EventSource.CLOSED) return;
    find("stage").textContent = "The server does not answer: trying again …";
    setTimeout(() => page.refresh().catch(() => listening.onerror()), AGAIN_MS);
  };
}

function show(now) {
  const busy = BUSY.includes(now.state), failed = now.state === "failed", title = now.title || "";
  find("study").hidden = find("ends").hidden = false;
  find("home").hidden = find("mine").hidden = true;
  find("headline").textContent = title || (now.clips ? "Untitled study" : "New study");
  find("progress").hidden = !busy && !failed;
  find("bar").hidden = find("stay").hidden = !busy;
  find("run").disabled = busy;
  find("steps").hidden = busy;
  if (now.share) find("bar").value = now.share; else find("bar").removeAttribute("value");
  find("stage").textContent = failed ? `No result: ${now.sentence}` : now.sentence;
  find("stage").className = failed ? "caution" : "";
  const step = failed ? find("stage").textContent : (now.sentence.match(/now ([^:]+):/) || ["", now.sentence])[1];
  if (step !== told) { told = step; find("told").textContent = step; }
  find("answer").hidden = !now.answer || busy;
  document.title = now.answer ? `${now.answer} – where to wear` : title || "Where to wear";
  if (busy) answered = "";
}

page.showStale = () => {
  const text = page.study.answer ? page.study.stale : "";
  find("stale").hidden = !text;
  find("stale").textContent = text;
  find("answer").classList.toggle("old", Boolean(text));
};

// What is missing before a run can work, and what it would take.
page.showReady = (counts) => {
  const enough = page.about.enough, able = counts.filter(([, clips]) => clips > 1);
  const few = counts.filter(([, clips]) => clips < 2).map(([name]) => `${name}: 1 clip, add 1`);
  const thin = counts.filter(([, clips]) => clips > 1 && clips < enough).map(([name, clips]) => `${name}: ${clips} clips, add ${enough - clips}`);
  const said = [
    page.study.problem,
    counts.length < 2 ? "At least two activities are needed." : "",
    few.length ? `Two clips or more are needed of each activity (${few.slice(0, 5).join("; ")}${few.length > 5 ? " …" : ""}).` : "",
    thin.length ? `From ${enough} clips on there are intervals (${thin.slice(0, 5).join("; ")}${thin.length > 5 ? " …" : ""}).` : "",
  ];
  find("cautions").textContent = said.filter(Boolean).join(" ");
  find("run").disabled = able.length < 2 || BUSY.includes(page.study.state);
  const clips = counts.reduce((sum, [, number]) => sum + number, 0), seconds = page.about.clip_s * clips;
  const minutes = seconds > 90 ? `${Math.round(seconds / 60)} min` : `${Math.max(1, Math.round(seconds))} s`;
  find("expected").textContent = seconds ? `${count(clips, "clip")}: about ${minutes}, as fast as the last run here.` : "";
  const form = find("ask"), subjects = people().size;
  if (!("by_subject" in page.study.parameters)) form.elements.by_subject.checked = subjects > 1;
  form.elements.by_subject.disabled = subjects < 2 && !form.elements.by_subject.checked;
};

function until() {
  const day = new Date(Date.now() + page.study.days_left * 864e5);
  find("until").textContent = `Kept until ${day.toLocaleDateString(undefined, { day: "numeric", month: "long", year: "numeric" })}, or longer if somebody looks at it.`;
}

page.refresh = async () => {
  const kept = page.study && labelsWait() ? new Map(page.study.table.map((row) => [row.file, row])) : new Map();
  const first = !page.study, typing = find("ask").contains(document.activeElement) || asked.busy;
  const study = await ask(here());
  if (typing && page.study) study.parameters = page.study.parameters;
  page.study = study;
  for (const row of study.table) {
    const before = kept.get(row.file);
    if (before) Object.assign(row, { activity: before.activity, subject: before.subject, use: before.use });
  }
  show(study);
  until();
  page.showStale();
  const busy = BUSY.includes(study.state), any = study.table.length > 0;
  find("label").hidden = find("go").hidden = !any;
  find("steps-title").hidden = !study.answer;
  if (first || answered !== study.answer) find("steps").open = !study.answer;
  if (first || !typing) fillAsked();
  drawAnswer(answered !== study.answer);
  answered = study.answer;
  if (!find("label").contains(document.activeElement)) drawClips(); else page.showReady([...counted()].sort());
  if (busy && (!listening || listening.readyState === EventSource.CLOSED)) listen();
  clearTimeout(page.later);
  if (!busy && study.table.some((row) => !row.judged)) page.later = setTimeout(() => page.refresh().catch((error) => complain(error.message)), 1000);
};

// Words of several places: the last one is completed.
function complete(event) {
  const before = event.target.value.includes(",") ? event.target.value.replace(/[^,]*$/, "") : "";
  find("places").replaceChildren(...page.about.places.map((word) => make("option", "", { value: before ? `${before} ${word}` : word })));
}

async function mine() {
  const all = await ask("/studies");
  find("mine").hidden = !all.length;
  find("studies").replaceChildren(...all.map((study) => {
    const line = make("li"), link = make("a", "", { href: `/studies/${study.id}` }), about = make("div");
    link.textContent = study.title || study.answer || `${count(study.clips, "clip")}, ${study.state}`;
    about.append(link);
    if (study.title && study.answer) about.append(make("small", study.answer));
    if (study.state === "failed") about.append(make("small", study.sentence, { class: "caution" }));
    const gone = make("button", "Delete", { type: "button", class: "button quiet", "aria-label": `Delete: ${link.textContent}` });
    gone.addEventListener("click", safely(async () => { if (confirm("Delete this study with all its files?")) { await ask(`/studies/${study.id}`, { method: "DELETE" }); await mine(); } }));
    line.append(about, make("span", study.made ? new Date(study.made * 1000).toLocaleDateString() : "", { class: "note" }), gone);
    return line;
  }));
}

function readyDrop() {
  const zone = find("zone"), send_ = (files) => upload(files, begin);
  const chosen = (event) => { const files = [...event.target.files].map((file) => [file.webkitRelativePath || file.name, file]); event.target.value = ""; return send_(files); };
  find("pick-files").addEventListener("click", () => find("files").click());
  find("pick-folder").addEventListener("click", () => find("folder").click());
  find("to-drop").addEventListener("click", () => find("files").click());
  find("files").addEventListener("change", safely(chosen));
  find("folder").addEventListener("change", safely(chosen));
  for (const kind of ["dragenter", "dragover"]) document.addEventListener(kind, (event) => { event.preventDefault(); zone.classList.add("over"); });
  document.addEventListener("dragleave", () => zone.classList.remove("over"));
  document.addEventListener("drop", safely(async (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
    await send_((await Promise.all(entries.map((entry) => inFolder(entry)))).flat());
  }));
}

function start() {
  readyDrop();
  readyClips();
  const form = find("ask");
  form.addEventListener("submit", safely(run));
  form.addEventListener("change", () => { complain(""); if (page.study) { page.study.parameters.by_subject ??= form.elements.by_subject.checked; parameters(); asked.soon(); find("headline").textContent = form.elements.title.value.trim() || "Untitled study"; } });
  find("demo").addEventListener("click", safely(async () => { await begin({ demo: true }); await page.refresh(); await run(); }));
  find("cancel").addEventListener("click", safely(async () => { await send(here("/cancel"), {}); await page.refresh(); }));
  find("longer").addEventListener("click", safely(async () => { page.study.days_left = (await send(here("/keep"), {})).days_left; until(); }));
  find("remove").addEventListener("click", safely(async () => { if (confirm("Delete this study with all its files?")) { await ask(here(), { method: "DELETE" }); location.href = "/"; } }));
  window.addEventListener("popstate", () => location.reload());
  return safely(async () => {
    page.about = await ask("/about");
    form.elements.sensor.replaceChildren(make("option", "as usual", { value: "" }), ...page.about.sensors.map((name) => make("option", name, { value: name })));
    readyAnswer();
    chips(find("ask-chips"), form);
    document.querySelectorAll("input[list=places]").forEach((input) => input.addEventListener("input", complete));
    complete({ target: { value: "" } });
    if (page.id) return page.refresh();
    find("home").hidden = find("steps").hidden = false;
    find("steps-title").hidden = true;
    turningBody();
    return mine();
  })();
}

start();
