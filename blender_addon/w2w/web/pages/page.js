// SPDX-License-Identifier: GPL-3.0-or-later
// What all parts of the page share: its study, and how the server is asked.
export const find = (name) => document.getElementById(name);

export function make(tag, content = "", attributes = {}) {
  const element = document.createElement(tag);
  element.textContent = content;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

export const page = {
  id: (location.pathname.match(/^\/studies\/([0-9a-f]{32})$/) || [])[1] || "",
  about: null, study: null, refresh: null,
};

export const count = (number, noun) => `${number} ${noun}${number === 1 ? "" : "s"}`;

export function complain(text) {
  find("problem").textContent = text;
  find("problem").hidden = !text;
}

export async function ask(path, options = {}) {
  const reply = await fetch(`/api${path}`, options).catch(() => { throw new Error("The server does not answer."); });
  const content = await reply.json().catch(() => ({ problem: `The server answered ${reply.status}.` }));
  if (reply.status === 401) location.reload();
  if (!reply.ok && !content.refused) throw new Error(content.problem);
  return content;
}

export const send = (path, content, method = "POST", more = {}) =>
  ask(path, { method, headers: { "content-type": "application/json" }, body: JSON.stringify(content), ...more });

export const here = (rest = "") => `/studies/${page.id}${rest}`;

// A handler whose errors are shown.
export const safely = (work) => (event) => {
  if (event && event.type === "submit") event.preventDefault();
  complain("");
  return Promise.resolve().then(() => work(event)).catch((error) => complain(error.message));
};

// Saves what was typed a moment later, one request at a time; a page that is left saves first.
export function saver(path, content, saved) {
  let waiting = 0, last = Promise.resolve();
  const now = () => {
    clearTimeout(waiting);
    waiting = 0;
    last = last.then(() => send(here(path), content(), "PUT", { keepalive: true })).then((found) => {
      find("saved").textContent = "Saved";
      saved(found);
    });
    last = last.catch((error) => complain(error.message));
    return last;
  };
  window.addEventListener("pagehide", () => { if (waiting) now(); });
  return {
    soon() { clearTimeout(waiting); find("saved").textContent = "Saving …"; waiting = setTimeout(now, 250); },
    flush: () => (waiting ? now() : last),
    get busy() { return Boolean(waiting); },
  };
}
