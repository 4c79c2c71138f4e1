// SPDX-License-Identifier: GPL-3.0-or-later
// Files and folders on their way to the study.
import { ask, count, find, here, make, page } from "./page.js";

// Files of dropped folders, each with its path; browsers give at most 100 entries at a time.
export async function inFolder(entry, above = "") {
  if (entry.isFile) return [[`${above}${entry.name}`, await new Promise((done, fail) => entry.file(done, fail))]];
  const reader = entry.createReader(), found = [];
  for (;;) {
    const some = await new Promise((done, fail) => reader.readEntries(done, fail));
    if (!some.length) return found;
    for (const each of some) found.push(...await inFolder(each, `${above}${entry.name}/`));
  }
}

// A folder above all others names the library, not an activity; so does one where loose files are downloaded to.
function withoutTop(files) {
  const tops = new Set(files.map(([name]) => name.split("/")[0]));
  const isLibrary = files.some(([name]) => name.split("/").length > 2 || name.endsWith("/labels.csv"));
  const isHeap = tops.size === 1 && /^(downloads?|desktop|documents|clips|motions?|data)$/i.test([...tops][0]);
  return tops.size === 1 && files.every(([name]) => name.includes("/")) && (isLibrary || isHeap)
    ? files.map(([name, file]) => [name.slice(name.indexOf("/") + 1), file]) : files;
}

const MOST_SHOWN = 12;

function refusedList(refused) {
  const lines = refused.slice(0, MOST_SHOWN).map(([name, why]) => make("li", `${name}: ${why}`));
  if (refused.length > MOST_SHOWN) lines.push(make("li", `… and ${refused.length - MOST_SHOWN} more`));
  find("refused").replaceChildren(...lines);
}

export async function upload(files, begin) {
  const readable = ([name]) => [...page.about.suffixes, ".zip"].some((end) => name.toLowerCase().endsWith(end));
  const taken = withoutTop(files.filter(readable)), others = files.filter((one) => !readable(one) && !one[0].split("/").pop().startsWith("."));
  const refused = others.map(([name]) => [name, "no kind of file that holds motion"]);
  if (!taken.length) { refusedList(refused); throw new Error("There is no motion file among these."); }
  if (!page.id) await begin({});
  const queue = taken.slice(), said = [];
  let done = 0, failed = 0;
  const say = () => {
    const left = others.length ? `, ${count(others.length, "file")} of other kinds left out` : "";
    find("uploading").textContent = `${done} of ${taken.length} files sent${failed ? `, ${failed} failed` : ""}${left}.`;
  };
  say();
  await Promise.all([0, 1, 2].map(async () => {
    for (let next = queue.shift(); next; next = queue.shift()) {
      const [name, file] = next;
      try {
        if (file.size > page.about.most) throw new Error(`larger than the ${Math.round(page.about.most / 1e6)} MB that are taken here`);
        const form = new FormData();
        form.append("files", file, name);
        const found = await ask(here("/files"), { method: "POST", body: form });
        refused.push(...Object.entries(found.refused), ...found.replaced.map((name) => [name, "it replaced another file of that name: rename it to keep both"]));
        if (found.said) said.push(found.said);
        done += 1;
      } catch (error) {
        failed += 1;
        refused.push([name, error.message]);
      }
      say();
    }
  }));
  if (said.length) find("uploading").append(` ${said.join(" ")}`);
  refusedList(refused);
  await page.refresh();
}
