// SPDX-License-Identifier: GPL-3.0-or-later
// What the page does: which map is shown, how it is coloured, what is read where one points.
"use strict";

function make(tag, content = "", attributes = {}) {
  const element = document.createElement(tag);
  element.textContent = content;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

const data = JSON.parse(document.getElementById("w2w-data").textContent);

(() => {
  const find = (name) => document.getElementById(name);
  const patches = data.names.length, maps = data.titles.length;
  const [expected, raw, low, high, expectedLow, expectedHigh] = ["expected", "raw", "low", "high", "expected_low", "expected_high"].map(
    (name) => Float32Array.from(unpack(data[name]), (value) => value / 65535));
  const asGood = unpack(data.as_good), scores = { expected, raw };
  const scored = { expected: "Expected F1", raw: "F1 on these clips" };
  const region = unpack(data.region), rank = unpack(data.rank), centres = unpack(data.centres);
  const spread = { count: unpack(data.spread_count), patch: unpack(data.spread_patch), share: unpack(data.spread_share) };
  const shown = { map: 0, scores: "expected", range: "own", patch: -1, listed: [] };
  let viewer = null;

  const score = (patch, map = shown.map) => scores[shown.scores][map * patches + patch];
  const number = (value) => value.toFixed(2);
  const onThese = (patch, map = shown.map) => {
    const at = map * patches + patch;
    return `${number(raw[at])} (${data.cautions[map] || `${number(low[at])}–${number(high[at])}`})`;
  };
  const meanInterval = (patch) => data.cautions[0] || `${number(expectedLow[patch])}–${number(expectedHigh[patch])}`;

  function range() {
    const all = scores[shown.scores];
    const values = shown.range === "own" ? all.subarray(shown.map * patches, (shown.map + 1) * patches) : all;
    let least = Infinity, most = -Infinity;
    for (const value of values) { least = Math.min(least, value); most = Math.max(most, value); }
    return [least, most];
  }

  // The scores at the two ends of the colours: scores that hardly differ shall not look far apart.
  function ends() {
    const [least, most] = range(), span = data.colour_span;
    if (most - least >= span) return [least, most];
    const end = Math.min(Math.max((least + most - span) / 2, 0), 1 - span);
    return [end, end + span];
  }

  // Scores spread over the vertices as the heatmaps are, then as shares of the colour range.
  function shares() {
    const [least, most] = ends(), width = most - least, result = new Float32Array(spread.count.length);
    let at = 0;
    for (let vertex = 0; vertex < result.length; vertex++) {
      let sum = 0, whole = 0;
      for (const end = at + spread.count[vertex]; at < end; at++) {
        sum += spread.share[at] * score(spread.patch[at]);
        whole += spread.share[at];
      }
      result[vertex] = width > 0 && whole > 0 ? (sum / whole - least) / width : 0.5;
    }
    return result;
  }

  function text(element, content) { element.textContent = content; return element; }

  function describe(target, patch) {
    const mean = shown.map === 0, level = data.cautions[0] ? "" : `${Math.round(100 * data.level)} % interval `;
    const sure = ` (${level}${meanInterval(patch)}${asGood[patch] ? "; as good" : ""})`;
    target.replaceChildren(
      make("b", data.names[patch]),
      make("span", `expected F1 ${number(expected[shown.map * patches + patch])}${mean ? sure : ""}, ${data.titles[shown.map]}`),
      make("br"),
      make("span", `on these clips ${onThese(patch)}${mean ? `, rank ${rank[2 * patch]}–${rank[2 * patch + 1]} of ${patches}` : ""}`),
    );
    if (!mean) target.append(make("br"), make("span", `mean over activities: expected F1 ${number(expected[patch])}${sure}`));
  }

  function point(patch) {
    shown.patch = patch;
    if (patch >= 0) describe(find("readout"), patch);
    badges();
  }

  function go(patch) {
    point(patch);
    if (viewer) viewer.face(centres[patch]);
  }

  // The best patch of each region by its expected F1 in the map shown, best first.
  function rankRegions() {
    const of = (values, patch) => values[shown.map * patches + patch], seen = new Set();
    const order = [...Array(patches).keys()].sort((a, b) => of(expected, b) - of(expected, a) || of(raw, b) - of(raw, a) || a - b);
    shown.listed = order.filter((patch) => !seen.has(region[patch]) && seen.add(region[patch])).slice(0, data.regions_listed);
    find("ranked").tBodies[0].replaceChildren(...shown.listed.map((patch) => {
      const row = make("tr"), cell = make("td"), button = make("button", data.names[patch], { type: "button", class: "go", "data-patch": patch });
      cell.append(button);
      const mean = shown.map === 0, few = data.cautions[shown.map];
      const onTheseClips = make("td", `${number(of(raw, patch))} `, { class: "n" });
      onTheseClips.append(make("span", few ? "too few clips" : `${number(of(low, patch))}–${number(of(high, patch))}`, { class: "interval" }));
      row.append(cell, make("td", `${mean && asGood[patch] ? "≈ " : ""}${number(of(expected, patch))}`, { class: "n" }),
        make("td", mean ? (few ? "too few clips" : meanInterval(patch)) : "–", { class: mean && few ? "n few" : "n" }), onTheseClips);
      return row;
    }));
    text(find("ranked-title"), data.titles[shown.map]);
  }

  function show() {
    const [least, most] = ends(), [lowest, highest] = range();
    text(find("bar-low"), number(least));
    text(find("bar-high"), number(most));
    text(find("scored"), scored[shown.scores]);
    find("bar-note").hidden = most - least <= highest - lowest + 1e-6;
    text(find("bar-note"), `The scores lie from ${number(lowest)} to ${number(highest)}: the colours span no less than ${number(data.colour_span)}.`);
    rankRegions();
    const best = shown.listed[0];
    describe(find("readout"), shown.patch >= 0 ? shown.patch : best);
    find("view").setAttribute("aria-label", `The body in 3D, coloured by ${shown.scores === "raw" ? scored.raw : "expected F1"} of ${data.titles[shown.map]}, from ${number(least)} to ${number(most)}; best: ${data.names[best]}`);
    if (viewer) viewer.paint(shares());
  }

  // The numbered sensors and the patch pointed at: where they stand on the canvas, and whether they are seen.
  function marks() {
    if (!viewer || !viewer.view || viewer.gl.isContextLost()) return [];
    const wanted = data.chosen.slice(0, 12).map((patch, i) => [patch, String(i + 1)]);
    if (shown.patch >= 0 && !data.chosen.slice(0, 12).includes(shown.patch)) wanted.push([shown.patch, ""]);
    return wanted.map(([patch, label]) => {
      const [x, y] = viewer.project(centres[patch]), seen = viewer.patchAt(x, y);
      // hidden where another part of the body is before it; at an outline nothing may be seen there
      return { x, y, label, hidden: seen >= 0 && viewer.apart(centres[seen], centres[patch]) > 0.12 };
    });
  }

  function badges() {
    const wanted = marks(), holder = find("badges");
    while (holder.children.length > wanted.length) holder.lastChild.remove();
    while (holder.children.length < wanted.length) holder.append(make("span"));
    wanted.forEach(({ x, y, label, hidden }, i) => {
      const badge = holder.children[i];
      text(badge, label);
      badge.className = (label ? "" : "pointer") + (hidden ? " hidden" : "");
      badge.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    });
  }

  function controls() {
    data.titles.forEach((name, map) => {
      const label = make("label"), input = make("input", "", { type: "radio", name: "map", value: map });
      input.checked = map === 0;
      input.addEventListener("change", () => { shown.map = map; show(); });
      label.append(input, make("span", name));
      find("maps").append(label);
    });
    document.querySelectorAll("input[name=scores]").forEach((input) =>
      input.addEventListener("change", () => { shown.scores = input.value; show(); }));
    document.querySelectorAll("input[name=range]").forEach((input) =>
      input.addEventListener("change", () => { shown.range = input.value; show(); }));
    document.addEventListener("click", (event) => {
      const button = event.target.closest("button.go");
      if (!button) return;
      if (button.dataset.map) {
        shown.map = Number(button.dataset.map);
        document.querySelectorAll("input[name=map]")[shown.map].checked = true;
        show();
      }
      go(Number(button.dataset.patch));
      const box = find("view").getBoundingClientRect();
      if (box.bottom < 120 || box.top > window.innerHeight - 120) find("view").scrollIntoView({ block: "center" });
    });
    const bar = find("bar").getContext("2d"), table = unpack(data.colours);
    const row = bar.createImageData(table.length / 3, 1);
    for (let i = 0; i < table.length / 3; i++) row.data.set([table[3 * i], table[3 * i + 1], table[3 * i + 2], 255], 4 * i);
    bar.putImageData(row, 0, 0);
  }

  function hover(event) {
    const box = find("view").getBoundingClientRect(), tip = find("tip");
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const patch = viewer.patchAt(x, y);
    tip.hidden = patch < 0;
    if (patch < 0) return;
    viewer.towards(centres[patch]);
    describe(tip, patch);
    point(patch);
    tip.style.left = `${Math.max(0, Math.min(x + 16, box.width - tip.offsetWidth - 4))}px`;
    tip.style.top = `${y + 20 + tip.offsetHeight > box.height ? Math.max(0, y - tip.offsetHeight - 12) : y + 20}px`;
  }

  function handling() {
    const canvas = find("view"), held = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
      hover(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) { hover(event); return; }
      const now = [event.clientX, event.clientY];
      if (held.size === 1) {
        find("tip").hidden = true;
        viewer.turn(-(now[0] - before[0]) * 0.009, (now[1] - before[1]) * 0.007);
      } else {
        const other = [...held].find(([id]) => id !== event.pointerId)[1];
        const spread = (finger) => Math.hypot(finger[0] - other[0], finger[1] - other[1]) || 1;
        viewer.closer(spread(now) / spread(before));
      }
      held.set(event.pointerId, now);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => held.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => { find("tip").hidden = true; });
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return; // the page scrolls until the body is clicked
      event.preventDefault();
      viewer.closer(Math.exp(-event.deltaY * 0.0012));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const step = 0.12, keys = {
        ArrowLeft: () => viewer.turn(step, 0), ArrowRight: () => viewer.turn(-step, 0),
        ArrowUp: () => viewer.turn(0, step), ArrowDown: () => viewer.turn(0, -step),
        "+": () => viewer.closer(1.15), "=": () => viewer.closer(1.15), "-": () => viewer.closer(1 / 1.15),
        Home: () => viewer.home(), n: () => next(1), p: () => next(-1), Escape: () => { find("tip").hidden = true; },
      };
      const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (!action || event.altKey || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      action();
      if (event.key.startsWith("Arrow") || event.key === "Home") say();
    });
    document.querySelectorAll("[data-turn]").forEach((button) => button.addEventListener("click", () => {
      viewer.yaw = (Number(button.dataset.turn) * Math.PI) / 180;
      viewer.pitch = 0.06;
      viewer.redraw();
      say();
    }));
    canvas.addEventListener("webglcontextlost", () => { live(false); badges(); });
    find("closer").addEventListener("click", () => viewer.closer(1.25));
    find("farther").addEventListener("click", () => viewer.closer(0.8));
  }

  // Tells those who do not see it from where the body is seen now, once it has stopped turning.
  let saying = 0;
  function say() {
    clearTimeout(saying);
    saying = setTimeout(() => {
      const sides = ["the front", "the front left", "the left", "the back left", "the back", "the back right", "the right", "the front right"];
      const side = sides[((Math.round(viewer.yaw / (Math.PI / 4)) % 8) + 8) % 8];
      const height = viewer.pitch > 0.4 ? ", from above" : viewer.pitch < -0.4 ? ", from below" : "";
      text(find("seen"), `Seen from ${side}${height}`);
    }, 250);
  }

  function next(step) {
    const at = shown.listed.indexOf(shown.patch), count = shown.listed.length;
    go(shown.listed[at < 0 ? (step > 0 ? 0 : count - 1) : (at + step + count) % count]);
  }

  // The body turns; else front and back stand still in its place.
  function live(turns) {
    document.querySelector(".stage").classList.toggle("live", turns);
    for (const element of [find("view"), find("look"), ...document.querySelectorAll(".turns button:not(#save)")]) element.hidden = !turns;
  }

  // F1 of products and regions by name, best first; a word that means nothing is said.
  function compare(event) {
    event.preventDefault();
    const words = find("places").value.split(",").map((word) => word.trim().toLowerCase().replace(/\s+/g, " ")).filter(Boolean);
    const at = (word) => (data.words[word] || []).reduce((best, patch) => (best < 0 || expected[patch] > expected[best] ? patch : best), -1);
    const found = words.map((word) => [word, at(word)]).sort((a, b) => (b[1] < 0 ? -1 : expected[b[1]]) - (a[1] < 0 ? -1 : expected[a[1]]));
    find("compared").replaceChildren(...found.map(([word, patch]) => {
      const row = make("li");
      if (patch < 0) return text(row, `${word}: nothing is called that; try ${data.products.join(", ")}`);
      row.append(make("button", word, { type: "button", class: "go", "data-patch": patch }),
        make("span", `: F1 ${number(expected[patch])} (${meanInterval(patch)})${asGood[patch] ? ", as good" : `, costs ${number(data.base_f1 - expected[patch])}`}`));
      return row;
    }));
  }

  // The answer as a picture for a slide: the sentence, the body as it is turned, products as bars.
  async function savePicture() {
    const sheet = make("canvas", "", { width: 1920, height: 1080 }), brush = sheet.getContext("2d");
    const still = document.querySelector("#body-still image"), body = new Image(), family = getComputedStyle(document.body).fontFamily;
    const write = (words, x, y, font, colour = "#1b2430") => { brush.font = `${font} ${family}`; brush.fillStyle = colour; brush.fillText(words, x, y); };
    const live = !find("view").hidden, stage = live ? find("view") : body;
    body.src = still.getAttribute("href");
    await body.decode();
    brush.fillStyle = "#ffffff";
    brush.fillRect(0, 0, 1920, 1080);
    let line = "", y = 190;
    brush.font = `bold 60px ${family}`;
    for (const word of `${document.querySelector("h1").textContent} `.split(" ")) {
      if (word && brush.measureText(`${line} ${word}`).width < 820) { line = `${line} ${word}`.trim(); continue; }
      write(line, 90, y, "bold 60px");
      [line, y] = [word, y + 76];
    }
    const disc = (label, x, down) => {
      brush.beginPath();
      brush.arc(x, down, 18, 0, 2 * Math.PI);
      brush.fillStyle = "#ffffff";
      brush.fill();
      brush.stroke();
      write(label, x - 8, down + 8, "bold 22px");
    };
    for (const product of document.querySelectorAll(".choices li")) {
      if ((y += 64) > 1010) break;
      const words = (part) => product.querySelector(part).textContent.trim().replace(/\s+/g, " ");
      const f1 = parseFloat(product.querySelector(".fill").style.width) / 100, number = words(".disc");
      if (number) disc(number, 108, y - 11);
      write(words(".go").replace(/^\d+ /, ""), 142, y, "bold 30px");
      brush.fillStyle = "#d9dee5";
      brush.fillRect(410, y - 26, 330, 30);
      brush.fillStyle = "#1a5598";
      brush.fillRect(410, y - 26, 330 * f1, 30);
      write(words(".n b"), 758, y, "bold 30px");
      write(words(".n .interval"), 840, y, "22px", "#4a5563");
    }
    const [width, height] = live ? [stage.clientWidth, stage.clientHeight] : [body.naturalWidth, body.naturalHeight];
    const scale = Math.min(880 / width, 860 / height), left = 980 + (880 - scale * width) / 2;
    brush.drawImage(stage, left, 60, scale * width, scale * height);
    const discs = live ? marks() : [...document.querySelectorAll(".stage .still circle")].map((disc, n) => (
      { x: disc.getAttribute("cx"), y: disc.getAttribute("cy"), label: String(n + 1) }));
    for (const { x, y: down, label, hidden } of discs.reverse()) if (!hidden && label) disc(label, left + scale * Number(x), 60 + scale * Number(down));
    brush.imageSmoothingEnabled = false;
    brush.drawImage(find("bar"), 1170, 960, 440, 20);
    write(live ? find("bar-low").textContent : still.dataset.low, 1095, 980, "26px");
    write(`${live ? find("bar-high").textContent : still.dataset.high}  ${live ? find("scored").textContent : scored.expected}`, 1630, 980, "26px");
    make("a", "", { href: sheet.toDataURL("image/png"), download: "where_to_wear.png" }).click();
  }

  // Paper shows what is folded on the screen.
  const folded = () => document.querySelectorAll(".panel details:not([open])");
  addEventListener("beforeprint", () => folded().forEach((part) => { part.open = part.dataset.printed = true; }));
  addEventListener("afterprint", () => document.querySelectorAll("[data-printed]").forEach((part) => { part.open = false; delete part.dataset.printed; }));

  controls();
  document.querySelector(".turns").hidden = false;
  find("save").addEventListener("click", savePicture);
  find("compare").hidden = false;
  find("compare").addEventListener("submit", compare);
  try {
    live(true); // a canvas that is not shown has no size
    viewer = new Viewer(find("view"), data);
    viewer.onDraw = badges;
    viewer.open(data.turn);
    handling();
  } catch (error) {
    live(false);
    console.warn(`W2W report: ${error.message}`);
  }
  show();
})();
