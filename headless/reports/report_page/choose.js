// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses sensors anew in the page, by the rules of `w2w place`: the paper's algorithm 2 under a designer's wishes.
"use strict";

(() => {
  const { names, choice } = data;
  const find = (name) => document.getElementById(name);
  const f1 = new Float32Array(unpack(choice.f1).buffer); // the bits of its numbers
  const patches = names.length, activities = choice.activities.length;
  const [ROUNDING, TIE] = [choice.rounding, choice.tie];
  const wishes = [];
  let chosen = null;

  // Adds the patch that raises the mean over activities of the best F1 most; of equals the first.
  function greedy(shown, allowed, required, target, most) {
    const order = [], after = [], covered = new Float64Array(shown.length);
    const weights = shown.map((activity) => choice.weights[activity] || 1); // background that is ticked counts once
    const whole = weights.reduce((sum, weight) => sum + weight, 0);
    const mean = () => covered.reduce((sum, value, at) => sum + weights[at] * value, 0) / whole;
    const gain = (patch) =>
      shown.reduce((sum, activity, at) => sum + weights[at] * Math.max(f1[patch * activities + activity] - covered[at], 0), 0) / whole;
    function take(candidates) {
      const gains = candidates.map(gain), best = Math.max(...gains);
      const patch = candidates[gains.findIndex((value) => value >= best - TIE)];
      order.push(patch);
      shown.forEach((activity, at) => { covered[at] = Math.max(covered[at], f1[patch * activities + activity]); });
      after.push(mean());
    }
    for (const options of required) if (!options.some((patch) => order.includes(patch))) take(options);
    while (order.length < most && (!order.length || mean() < target - ROUNDING)) {
      const rest = allowed.filter((patch) => !order.includes(patch));
      if (order.length && !(Math.max(0, ...rest.map(gain)) > ROUNDING)) break;
      take(rest);
    }
    return { order, after, reached: after[after.length - 1] >= target - ROUNDING };
  }

  function read() {
    const shown = [...find("choose-activities").querySelectorAll("input")].filter((box) => box.checked).map((box) => Number(box.value));
    const side = document.querySelector("input[name=choose-side]:checked").value;
    const closed = new Set(side === "any" ? [] : choice.words[side === "left" ? "right" : "left"] || []);
    wishes.filter((wish) => wish.kind === "forbid").forEach((wish) => choice.words[wish.words].forEach((patch) => closed.add(patch)));
    const allowed = [...Array(patches).keys()].filter((patch) => !closed.has(patch));
    const required = wishes.filter((wish) => wish.kind === "must").map((wish) => {
      const options = choice.words[wish.words].filter((patch) => !closed.has(patch));
      if (!options.length) throw new Error(`“${wish.words}” must be chosen, but no spot there is allowed.`);
      return options;
    });
    const target = find("choose-target").valueAsNumber;
    const most = find("choose-most").value === "" ? allowed.length : find("choose-most").valueAsNumber;
    if (!shown.length) throw new Error("Tick at least one activity.");
    if (!allowed.length) throw new Error("No spot is left to choose from: forbid less.");
    if (!(target > 0 && target <= 1)) throw new Error("The target is an F1: above 0, and 1 at most.");
    if (!(Number.isInteger(most) && most >= 1)) throw new Error("At most: a whole number, 1 or more.");
    if (most < required.length) throw new Error(`${required.length} spots must be chosen, but no more than ${most} may be.`);
    return [shown, allowed, required, target, most];
  }

  function choose() {
    const said = find("choose-said"), rows = find("chosen").tBodies[0];
    try {
      const wished = read();
      chosen = greedy(...wished);
      const count = chosen.order.length, value = chosen.after[count - 1].toFixed(3);
      said.className = "";
      said.textContent = `${count} sensor${count === 1 ? " reaches" : "s reach"} a best-of F1 of ${value} on these clips` +
        ` (target ${Number(wished[3].toPrecision(3))}${chosen.reached ? "" : ", not reached"}).`;
    } catch (error) {
      chosen = null;
      said.className = "caution";
      said.textContent = error.message;
    }
    rows.replaceChildren(...(chosen ? chosen.order : []).map((patch, at) => {
      const row = make("tr"), cell = make("td");
      cell.append(make("button", names[patch], { type: "button", class: "go", "data-patch": patch }));
      row.append(make("td", String(at + 1), { class: "n" }), cell, make("td", chosen.after[at].toFixed(3), { class: "n" }));
      return row;
    }));
    find("choose-csv").disabled = !chosen;
    document.dispatchEvent(new CustomEvent("w2w-chosen", { detail: chosen ? chosen.order : [] }));
  }

  function listWishes() {
    find("choose-wishes").replaceChildren(...wishes.map((wish, at) => {
      const item = make("li", `${wish.kind === "must" ? "Must" : "Forbid"}: ${wish.words} `);
      const remove = make("button", "Remove", { type: "button", "aria-label": `Remove: ${wish.kind} ${wish.words}` });
      remove.addEventListener("click", () => { wishes.splice(at, 1); listWishes(); choose(); });
      item.append(remove);
      return item;
    }));
  }

  function add() {
    const words = find("choose-words").value.trim().toLowerCase(), kind = find("choose-kind").value;
    if (!(words in choice.words)) {
      find("choose-said").className = "caution";
      find("choose-said").textContent = words ? `No spot is called “${words}”: take one of the list.` : "Name a spot first.";
      return;
    }
    wishes.push({ kind, words });
    find("choose-words").value = "";
    listWishes();
    choose();
  }

  // A cell that a spreadsheet would take for a formula gets a quotation mark before it.
  const cell = (text) => `"${(/^[=+\-@\t\r]/.test(text) ? `'${text}` : text).replaceAll('"', '""')}"`;

  function save() {
    const rows = chosen.order.map((patch, at) => [at + 1, patch, cell(names[patch]), chosen.after[at].toFixed(6)].join(","));
    const table = ["sensor,patch,name,best_of_f1", ...rows, ""].join("\r\n");
    const link = make("a", "", { href: `data:text/csv;charset=utf-8,${encodeURIComponent(table)}`, download: "sensors.csv" });
    link.click();
  }

  choice.activities.forEach((name, activity) => {
    const label = make("label"), box = make("input", "", { type: "checkbox", value: activity });
    box.checked = choice.weights[activity] > 0;
    label.append(box, make("span", ` ${name}`));
    find("choose-activities").append(label);
  });
  find("choose-known").append(...Object.keys(choice.words).map((words) => make("option", "", { value: words })));
  find("choose-target").value = choice.target;
  find("choose-most").value = choice.most;
  find("choose").addEventListener("change", (event) => { if (!["choose-words", "choose-kind"].includes(event.target.id)) choose(); });
  find("choose-words").addEventListener("keydown", (event) => { if (event.key === "Enter") add(); });
  find("choose-add").addEventListener("click", add);
  find("choose-csv").addEventListener("click", save);
  listWishes();
})();
