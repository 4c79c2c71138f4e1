// SPDX-License-Identifier: GPL-3.0-or-later
// The answer: the report, and what it would be under other wishes.
import { ask, complain, find, here, make, page, safely, send } from "./page.js";
import { readyPilot } from "./pilot.js";

const TEXTS = ["only", "forbid", "must", "background"], NUMBERS = ["target", "every_activity", "max_places"];
const MODES = { only: "only at", forbid: "never at", must: "always at" };
let shown = "", last = null;

const words = (input) => input.value.split(",").map((word) => word.trim()).filter(Boolean);

// The wishes of a form: numbers as numbers, and nothing of what is empty.
export function wishes(form) {
  const given = {};
  for (const name of TEXTS) if (form.elements[name].value.trim()) given[name] = form.elements[name].value.trim();
  for (const name of NUMBERS) if (form.elements[name].value !== "") given[name] = Number(form.elements[name].value);
  return given;
}

export function fill(form, given) {
  for (const name of [...TEXTS, ...NUMBERS]) form.elements[name].value = given[name] ?? "";
  form.dispatchEvent(new Event("filled"));
}

// Products and parts of the body as buttons that add their word to a wish, or take it away.
export function chips(place, form) {
  const mode = make("span", "", { class: "modes", role: "group", "aria-label": "A click means" });
  let now = "only";
  const all = [];
  const draw = () => {
    for (const button of mode.children) button.setAttribute("aria-pressed", String(button.dataset.mode === now));
    for (const chip of all) {
      const name = Object.keys(MODES).find((one) => words(form.elements[one]).includes(chip.dataset.word));
      chip.className = `chip ${name || ""}`;
      chip.setAttribute("aria-pressed", String(Boolean(name)));
      chip.title = name ? `${MODES[name]} ${chip.dataset.word}` : "";
    }
  };
  for (const [name, text] of Object.entries(MODES)) {
    const button = make("button", text, { type: "button", class: `mode ${name}`, "data-mode": name });
    button.addEventListener("click", () => { now = name; draw(); });
    mode.append(button);
  }
  for (const word of [...page.about.products, ...page.about.parts]) {
    const chip = make("button", word, { type: "button", class: "chip", "data-word": word });
    chip.addEventListener("click", () => {
      const there = Object.keys(MODES).find((name) => words(form.elements[name]).includes(word));
      for (const name of Object.keys(MODES)) form.elements[name].value = words(form.elements[name]).filter((one) => one !== word).join(", ");
      if (there !== now) form.elements[now].value = [...words(form.elements[now]), word].join(", ");
      draw();
      form.dispatchEvent(new Event("change", { bubbles: true }));
    });
    all.push(chip);
  }
  const group = make("span", "", { class: "group" });
  group.append(...all);
  place.replaceChildren(make("span", "A click means", { class: "note" }), mode, group);
  form.addEventListener("change", draw);
  form.addEventListener("filled", draw);
  draw();
}

const address = (given) => `/api${here("/files/report.html")}${given ? `?wishes=${encodeURIComponent(JSON.stringify(given))}` : ""}`;
const NEED = "&need=1";

// Wishes under which the page chooses: what the run wished and the form has cleared is taken back.
function asked() {
  const given = wishes(find("again"));
  for (const name of [...TEXTS, ...NUMBERS]) if (!(name in given) && page.study.parameters[name] !== undefined) given[name] = "";
  return given;
}

async function again() {
  const given = asked();
  find("chosen").textContent = "Choosing …";
  try {
    const found = await send(here("/place"), given);
    const set = found.worn_together;
    find("chosen").textContent = `${found.answer.sentence}${set && set.places.length > 1 ? ` ${set.sentence}.` : ""}`;
    show(given);
  } catch (error) { find("chosen").textContent = ""; throw error; }
}

function show(given, more = "") {
  const to = address(given) + more;
  if (shown === to) return;
  shown = to;
  last = given;
  find("report").classList.toggle("chosen", Boolean(given));
  find("report").src = find("open").href = to;
}

const said = (given) => Object.entries(given).filter(([, value]) => value !== "").map(([name, value]) => `${{ ...MODES, target: "F1", every_activity: "every activity", max_places: "sensors at most", background: "background" }[name]} ${value}`).join("; ") || "as the run";

function keep() {
  const given = asked(), text = find("chosen").textContent || page.study.answer, card = make("li");
  const see = make("button", "Show", { type: "button", class: "button" }), gone = make("button", "Forget", { type: "button", class: "button quiet" });
  see.addEventListener("click", () => { fill(find("again"), given); find("chosen").textContent = text; show(given); });
  gone.addEventListener("click", () => card.remove());
  const buttons = make("p", "", { class: "buttons" });
  buttons.append(see, gone);
  card.append(make("b", said(given)), make("p", text), buttons);
  find("choices").append(card);
}

export function drawAnswer(fresh) {
  const study = page.study, base = `/api${here()}`;
  if (!study.answer) return;
  find("zip").href = `${base}/results.zip`;
  if (fresh) {
    shown = "";
    show(null);
    fill(find("again"), study.parameters);
    find("chosen").textContent = "";
    find("choices").replaceChildren();
  }
  const tables = study.files.filter((name) => /^[^/]+\.(csv|blend|json)$/.test(name));
  find("downloads").replaceChildren(...tables.flatMap((name) => [make("a", name, { href: `${base}/files/${encodeURIComponent(name)}` }), make("span", " ")]));
  share(study.link);
}

function share(link) {
  find("shared").hidden = !link;
  find("link").value = link;
}

// A button on the report's first card that tries cheaper sensors there.
function offerNeed(inner) {
  const card = inner.querySelector("#cards article");
  if (!card || inner.querySelector("#cards details")) return;
  const button = make("button", "How cheap?", { type: "button", id: "how-cheap", title: "Tries cheaper sensors here, as w2w need does" });
  button.addEventListener("click", () => {
    button.disabled = true;
    button.textContent = "Trying cheaper sensors …";
    show(last ?? {}, NEED);
  });
  const line = make("p", "", { class: "turns" });
  line.append(button);
  card.append(line);
}

// The report is as high as what stands in it: one page scrolls, not two.
function fit() {
  const inner = find("report").contentDocument;
  if (inner && inner.body) find("report").style.height = `${inner.body.scrollHeight + 8}px`;
}

export function readyAnswer() {
  const form = find("again");
  form.querySelector(".wishes").append(...[...find("ask").querySelectorAll(".wishes label")].map((label) => label.cloneNode(true)));
  chips(find("again-chips"), form);
  let soon = 0;
  form.addEventListener("submit", safely(() => { clearTimeout(soon); return again(); }));
  form.addEventListener("change", () => { clearTimeout(soon); soon = setTimeout(safely(again), 400); });
  find("keep-choice").addEventListener("click", keep);
  readyPilot(() => { shown = ""; show(last); });
  find("as-run").addEventListener("click", () => { fill(form, page.study.parameters); find("chosen").textContent = ""; complain(""); show(null); });
  find("again-part").addEventListener("toggle", (event) => event.target.open && send(here("/place"), {}).catch(() => {})); // what takes seconds once is begun
  find("share").addEventListener("click", safely(async () => { share((await send(here("/share"), {})).link); find("link").select(); }));
  find("unshare").addEventListener("click", safely(async () => { await ask(here("/share"), { method: "DELETE" }); share(""); }));
  find("copy").addEventListener("click", safely(async () => {
    find("link").select();
    await (navigator.clipboard ? navigator.clipboard.writeText(find("link").value) : document.execCommand("copy"));
    find("copy").textContent = "Copied";
  }));
  find("report").addEventListener("load", () => {
    fit();
    const inner = find("report").contentDocument;
    if (!inner || !inner.body) return;
    if (inner.contentType === "application/json") {
      complain((inner.body.textContent.match(/"problem":\s*"(.*)"}/) || ["", "That cannot be shown."])[1]);
      show(last);
      return;
    }
    new ResizeObserver(fit).observe(inner.body);
    offerNeed(inner);
  });
}
