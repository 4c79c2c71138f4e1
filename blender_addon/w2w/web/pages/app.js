// SPDX-License-Identifier: GPL-3.0-or-later
// The app's page: uploads, the table of clips, the run's progress, the answer.
"use strict";

(() => {
  const find = (name) => document.getElementById(name);
  const make = (tag, content = "", attributes = {}) => {
    const element = document.createElement(tag);
    element.textContent = content;
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    return element;
  };
  const page = { id: (location.pathname.match(/^\/studies\/([0-9a-f]{32})$/) || [])[1] || "", about: null, study: null, edited: false, answered: "", listening: null };

  const complain = (text) => { find("problem").textContent = text; find("problem").hidden = !text; };

  async function ask(path, options = {}) {
    const reply = await fetch(`/api${path}`, options).catch(() => { throw new Error("The server does not answer"); });
    const content = await reply.json().catch(() => ({ problem: `The server answered ${reply.status}` }));
    if (!reply.ok && !content.refused) throw new Error(content.problem);
    return content;
  }
  const send = (path, content, method = "POST") => ask(path, { method, headers: { "content-type": "application/json" }, body: JSON.stringify(content) });
  const here = (rest = "") => `/studies/${page.id}${rest}`;
  const safely = (work) => (event) => {
    if (event && event.type === "submit") event.preventDefault();
    complain("");
    return Promise.resolve(work(event)).catch((error) => complain(error.message));
  };

  // Files of dropped folders, each with its path; browsers give at most 100 entries at a time.
  async function inFolder(entry, above = "") {
    if (entry.isFile) return [[`${above}${entry.name}`, await new Promise((done, fail) => entry.file(done, fail))]];
    const reader = entry.createReader(), found = [];
    for (;;) {
      const some = await new Promise((done, fail) => reader.readEntries(done, fail));
      if (!some.length) return found;
      for (const each of some) found.push(...await inFolder(each, `${above}${entry.name}/`));
    }
  }

  // A folder above all others names the library, not an activity.
  function withoutTop(files) {
    const tops = new Set(files.map(([name]) => name.split("/")[0]));
    const isLibrary = files.some(([name]) => name.split("/").length > 2 || name.endsWith("/labels.csv"));
    return tops.size === 1 && isLibrary ? files.map(([name, file]) => [name.slice(name.indexOf("/") + 1), file]) : files;
  }

  async function upload(files) {
    const taken = withoutTop(files.filter(([name]) => [...page.about.suffixes, ".zip"].some((end) => name.toLowerCase().endsWith(end))));
    if (!taken.length) throw new Error("There is no motion file among these.");
    const big = taken.find(([, file]) => file.size > page.about.most);
    if (big) throw new Error(`${big[0]} is larger than the ${Math.round(page.about.most / 1e6)} MB that are taken here.`);
    if (!page.id) await begin({});
    const refused = [], left = files.length - taken.length, queue = taken.slice();
    let done = 0;
    const say = () => { find("uploading").textContent = `${done} of ${taken.length} files sent${left ? `, ${left} of other kinds left out` : ""}.`; };
    say();
    await Promise.all([0, 1, 2].map(async () => {
      for (let next = queue.shift(); next; next = queue.shift()) {
        const form = new FormData();
        form.append("files", next[1], next[0]);
        const found = await ask(here("/files"), { method: "POST", body: form });
        refused.push(...Object.entries(found.refused));
        done += 1;
        say();
      }
    }));
    find("refused").replaceChildren(...refused.map(([name, why]) => make("li", `${name}: ${why}`)));
    await refresh();
  }

  async function begin(content) {
    page.id = (await send("/studies", content)).id;
    history.pushState(null, "", `/studies/${page.id}`);
    find("mine").hidden = true;
  }

  function held(row) {
    const facts = row.judged;
    if (!facts) return ["being looked at …", ""];
    if (facts.problem) return [`cannot be used: ${facts.problem}`, "caution"];
    const up = facts.up ? `, ${facts.up} up` : "", cut = facts.cut ? `; left out: ${facts.cut}` : "";
    return [`${facts.duration_s.toFixed(1)} s at ${Math.round(facts.frame_rate)} frames/s${up}${cut}`, ""];
  }

  const box = (row, name, more = {}) => {
    const input = make("input", "", { type: "text", maxlength: 80, "aria-label": `${name} of ${row.name}`, ...more });
    input.value = row[name] || "";
    input.addEventListener("change", () => { row[name] = input.value.trim(); edited(); });
    return input;
  };

  function edited() {
    page.edited = true;
    activities();
  }

  // Draws the table anew; whoever types stays where they are.
  function clips() {
    const inputs = () => [...find("label").querySelectorAll("input")], at = inputs().indexOf(document.activeElement);
    find("clips").replaceChildren(...page.study.table.map((row) => {
      const line = make("tr"), [text, kind] = held(row), use = make("input", "", { type: "checkbox", "aria-label": `Use ${row.name}` });
      row.use = row.use ?? Boolean(row.activity);
      use.checked = row.use;
      line.className = row.use ? "" : "out";
      use.addEventListener("change", () => { row.use = use.checked; line.className = row.use ? "" : "out"; edited(); });
      const cells = [make("td", row.name, { class: "file" }), make("td", text, { class: kind }), make("td"), make("td"), make("td")];
      cells[2].append(box(row, "activity", { list: "names" }));
      cells[3].append(box(row, "subject"));
      cells[4].append(use);
      line.append(...cells);
      return line;
    }));
    activities();
    if (at >= 0 && inputs()[at]) inputs()[at].focus();
  }

  // The activities with their numbers of clips, each to be renamed, and what is wrong with them.
  function activities() {
    const used = page.study.table.filter((row) => row.use && row.activity && !(row.judged && row.judged.problem)), counts = new Map();
    for (const row of used) counts.set(row.activity, (counts.get(row.activity) || 0) + 1);
    const names = [...counts.keys()].sort();
    find("names").replaceChildren(...names.map((name) => make("option", "", { value: name })));
    find("activities").replaceChildren(...names.map((name) => {
      const label = make("label", `${counts.get(name)} clip${counts.get(name) === 1 ? "" : "s"}`), input = make("input", "", { type: "text", list: "names", maxlength: 80, "aria-label": `New name of ${name}` });
      input.value = name;
      input.addEventListener("change", () => {
        const to = input.value.trim();
        for (const row of page.study.table) if (row.activity === name && to) row.activity = to;
        page.edited = true;
        setTimeout(clips); // when the next field has the focus
      });
      label.append(input);
      return label;
    }));
    const few = names.filter((name) => counts.get(name) < 2);
    find("cautions").textContent = [
      page.study.problem, names.length < 2 ? "At least two activities are needed." : "",
      few.length ? `Two clips or more are needed of: ${few.join(", ")}.` : "",
    ].filter(Boolean).join(" ");
  }

  function wishes(form) {
    const given = {};
    for (const [name, value] of new FormData(form)) {
      if (value !== "") given[name] = ["target", "max_places"].includes(name) ? Number(value) : value;
    }
    return given;
  }

  async function run() {
    if (page.edited) {
      await send(here("/labels"), page.study.table.map((row) => ({ file: row.file, activity: row.use ? row.activity : "", subject: row.subject || "" })), "PUT");
      page.edited = false;
    }
    show(await send(here("/run"), { ...page.study.parameters, ...wishes(find("ask")) }));
    listen();
  }

  function listen() {
    if (page.listening) page.listening.close();
    page.listening = new EventSource(`/api${here("/events")}`);
    page.listening.onmessage = (event) => {
      const now = JSON.parse(event.data);
      show(now);
      if (!["queued", "running"].includes(now.state)) { page.listening.close(); refresh().catch((error) => complain(error.message)); }
    };
  }

  function show(now) {
    const busy = ["queued", "running"].includes(now.state);
    find("bar").hidden = find("cancel").hidden = find("stay").hidden = !busy;
    find("run").disabled = busy;
    find("drop").hidden = find("label").hidden = busy;
    if (now.share) find("bar").value = now.share; else find("bar").removeAttribute("value");
    find("stage").textContent = now.state === "failed" ? `No result: ${now.sentence}` : now.sentence;
    find("stage").className = now.state === "failed" ? "caution" : "";
    find("answer").hidden = !now.answer;
    find("headline").textContent = "Your study";
    document.title = now.answer ? `${now.answer} – where to wear` : "Where to wear";
    find("lead").hidden = true;
    if (busy) page.answered = "";
  }

  function answer() {
    const study = page.study, base = `/api${here()}`;
    if (!study.answer || page.answered === study.answer) return;
    page.answered = study.answer;
    find("zip").href = `${base}/results.zip`;
    find("open").href = find("report").src = `${base}/files/report.html`;
    const tables = study.files.filter((name) => /^[^/]+\.(csv|blend|json)$/.test(name));
    find("downloads").replaceChildren(...tables.flatMap((name) => [make("a", name, { href: `${base}/files/${encodeURIComponent(name)}` }), make("span", " ")]));
    find("chosen").textContent = "";
    for (const [name, value] of Object.entries(study.parameters)) {
      for (const form of [find("again"), find("ask")]) if (form.elements[name]) form.elements[name].value = value;
    }
  }

  async function refresh() {
    const kept = page.edited && page.study ? new Map(page.study.table.map((row) => [row.file, row])) : new Map();
    page.study = await ask(here());
    for (const row of page.study.table) {
      const before = kept.get(row.file);
      if (before) Object.assign(row, { activity: before.activity, subject: before.subject, use: before.use });
    }
    show(page.study);
    const busy = ["queued", "running"].includes(page.study.state), any = page.study.table.length > 0;
    find("label").hidden = busy || !any;
    find("go").hidden = !any;
    find("demo").hidden = any;
    answer();
    if (!find("clips").contains(document.activeElement) && !find("activities").contains(document.activeElement)) clips();
    if (busy && (!page.listening || page.listening.readyState === EventSource.CLOSED)) listen();
    clearTimeout(page.later);
    if (!busy && page.study.table.some((row) => !row.judged)) page.later = setTimeout(() => refresh().catch((error) => complain(error.message)), 1000);
  }

  async function again() {
    const form = find("again"), asked = wishes(form), started = performance.now();
    for (const name of ["only", "forbid", "must"]) asked[name] = asked[name] || "";
    find("chosen").textContent = "Choosing …";
    try {
      const found = await send(here("/place"), asked);
      const set = found.worn_together, together = set && set.places.length > 1 ? ` Together: ${set.places.map((one) => one.product || one.name).join(", ")}, F1 ${set.expected_f1.toFixed(2)}.` : "";
      find("chosen").textContent = `${found.answer.sentence}${together} (${((performance.now() - started) / 1000).toFixed(1)} s)`;
    } catch (error) { find("chosen").textContent = ""; throw error; }
  }

  // Words of several places: the last one is completed.
  function complete(event) {
    const before = event.target.value.includes(",") ? event.target.value.replace(/[^,]*$/, "") : "";
    find("places").replaceChildren(...page.about.places.map((word) => make("option", "", { value: before ? `${before} ${word}` : word })));
  }

  async function mine() {
    const all = await ask("/studies");
    find("mine").hidden = !all.length;
    find("studies").replaceChildren(...all.map((study) => {
      const line = make("li"), link = make("a", study.answer || `${study.clips} clips, ${study.state}`, { href: `/studies/${study.id}` });
      const gone = make("button", "Delete", { type: "button", class: "button", "aria-label": `Delete: ${link.textContent}` });
      gone.addEventListener("click", safely(async () => { if (confirm("Delete this study with all its files?")) { await ask(`/studies/${study.id}`, { method: "DELETE" }); await mine(); } }));
      line.append(link, make("span", new Date(study.made * 1000).toLocaleString(), { class: "note" }), gone);
      return line;
    }));
  }

  // The report is as high as what stands in it: one page scrolls, not two.
  function fit() {
    const inner = find("report").contentDocument;
    if (inner && inner.body) find("report").style.height = `${inner.body.scrollHeight + 8}px`;
  }

  function start() {
    const zone = find("zone"), pick = (name) => find(name).click();
    const chosen = (event) => { const files = [...event.target.files].map((file) => [file.webkitRelativePath || file.name, file]); event.target.value = ""; return upload(files); };
    find("pick-files").addEventListener("click", () => pick("files"));
    find("pick-folder").addEventListener("click", () => pick("folder"));
    find("files").addEventListener("change", safely(chosen));
    find("folder").addEventListener("change", safely(chosen));
    find("demo").addEventListener("click", safely(async () => { await begin({ demo: true }); await refresh(); }));
    for (const kind of ["dragenter", "dragover"]) document.addEventListener(kind, (event) => { event.preventDefault(); zone.classList.add("over"); });
    document.addEventListener("dragleave", () => zone.classList.remove("over"));
    document.addEventListener("drop", safely(async (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
      await upload((await Promise.all(entries.map((entry) => inFolder(entry)))).flat());
    }));
    find("again").querySelector(".wishes").append(...[...find("ask").querySelectorAll(".wishes label")].map((label) => label.cloneNode(true)));
    document.querySelectorAll("input[list=places]").forEach((input) => input.addEventListener("input", complete));
    find("ask").addEventListener("submit", safely(run));
    find("again").addEventListener("submit", safely(again));
    find("again-part").addEventListener("toggle", (event) => event.target.open && send(here("/place"), {}).catch(() => {})); // what takes seconds once is begun
    find("cancel").addEventListener("click", safely(async () => { await send(here("/cancel"), {}); await refresh(); }));
    find("remove").addEventListener("click", safely(async () => { if (confirm("Delete this study with all its files?")) { await ask(here(), { method: "DELETE" }); location.href = "/"; } }));
    find("report").addEventListener("load", () => { fit(); new ResizeObserver(fit).observe(find("report").contentDocument.body); });
    window.addEventListener("popstate", () => location.reload());
    return safely(async () => {
      page.about = await ask("/about");
      find("ask").elements.sensor.replaceChildren(make("option", "as usual", { value: "" }), ...page.about.sensors.map((name) => make("option", name, { value: name })));
      complete({ target: { value: "" } });
      await (page.id ? refresh() : mine());
    })();
  }

  start();
})();
