"use strict";
// The page of `wirewear open`: files are put, steps started, and what they say shown until they end.
const find = id => document.getElementById(id);
const made = (kind, values = {}, ...inside) => {
  const one = Object.assign(document.createElement(kind), values);
  one.append(...inside);
  return one;
};
const WORDS = { idle: "", running: "running", done: "done", failed: "failed" };
const shown = new Map();
// Units that a value may be in, by what a command calls it, with factors to the one that the command takes, the first.
const UNITS = { MM: { mm: 1, "µm": 1e-3, in: 25.4 }, UM: { "µm": 1, mm: 1e3, nm: 1e-3 }, N: { N: 1, mN: 1e-3, kN: 1e3, kgf: 9.80665, lbf: 4.4482216152605 },
  HZ: { Hz: 1, "1/min": 1 / 60, kHz: 1e3 }, DEG: { "°": 1, rad: 180 / Math.PI }, GB: { GB: 1, MB: 1e-3 }, MPa: { MPa: 1, GPa: 1e3 },
  UM_PER_N: { "µm/N": 1, "mm/N": 1e3 }, mm3: { "mm³": 1, "µm³": 1e-9 }, "mm3/J": { "mm³/J": 1, "µm³/J": 1e-9, "µm³/mJ": 1e-6 } };
// What the kinds of contact are called, their sketches, and options that only some of them have.
const KINDS = { "crossed-wires": "two wires that cross", "ball-on-flat": "ball on flat", "cylinder-on-flat": "cylinder on flat",
  "line-contact": "flat with rounded edges on flat", "point-contact": "two other bodies",
  joint: "a joint, by its loops alone" };
const FLAT = '<path d="M6 40h84v16H6z"/>';
const SKETCHES = { "crossed-wires": '<path d="M6 32h84v14H6z"/><circle cx="48" cy="20" r="12"/>', "ball-on-flat": FLAT + '<circle cx="48" cy="22" r="18"/>',
  "cylinder-on-flat": FLAT + '<path d="M26 8h46a9 16 0 0 1 0 32H26"/><ellipse cx="26" cy="24" rx="9" ry="16"/>',
  "line-contact": FLAT + '<path d="M24 8h48v24q0 8-8 8H32q-8 0-8-8z"/>', "point-contact": '<path d="M6 56q42-34 84 0zM14 6q34 60 68 0z"/>',
  joint: '<path d="M6 24h58v10H6zM32 34h58v10H32zM40 14h16v10H40zM44 44h8v10h-8z"/>' };
const LINES = ["cylinder-on-flat", "line-contact"];
const ONLY = { "--length": LINES, "--radius": LINES, "--face-half-width": LINES, "--edge-radius": LINES, "--pad-material": [...LINES, "ball-on-flat"],
  "--material": Object.keys(KINDS).filter(one => one !== "joint"), "--diameter": ["crossed-wires", "ball-on-flat"], "--crossing-angle": ["crossed-wires"] };
const named = flag => flag.replace(/^-+/, "").replaceAll("-", " ");
// On a page, an option of the command line is a field, and a command a step.
const titles = {};
const forPage = text => text.replace(/`wirewear ([a-z]+)[^`]*`|(?<=then: )wirewear ([a-z]+).*/g, (own, quoted, last) => `“${titles[quoted ?? last] ?? own}”`)
  .replace(/,? for a mapping(?: of one)?\./g, ".").replace(/^For a mapping\.\s*/, "")
  .replace(/^wirewear: .* is at work.*\n?/gm, "").replace(/^wirewear: /gm, "")
  .replace(/--([a-z][a-z-]*)/g, (_, name) => `“${named(name)}”`);

const ENDED = "The program behind this page has ended: start it again.";
function say(problem) {
  find("problem").hidden = !problem;
  find("problem").textContent = problem;
}

// What went wrong, or nothing; it stays on the page until something is put again.
async function ask(method, place, body) {
  const answer = await fetch(place, { method, body }).then(async one => ({ ok: one.ok, text: await one.text() })).catch(() => null);
  const unsent = body instanceof File ? `${body.name} was not taken: it is a folder, or cannot be read.` : ENDED;
  const problem = answer === null ? unsent : answer.ok ? "" : answer.text;
  if (method === "PUT" || problem || find("problem").textContent === ENDED) say(problem);
  if (!problem) show(JSON.parse(answer.text));
  return problem;
}

async function put(files) {
  const problems = [];
  for (const file of [...files]) problems.push(await ask("PUT", "files/" + encodeURIComponent(file.name), file));
  say(problems.filter(Boolean).join(" "));
}

// A folder holds the tests of a campaign; names are those below it.
async function putFolder(files) {
  const problems = [];
  for (const [name, file] of files)
    if (!name.split("/").some(one => one.startsWith("."))) problems.push(await ask("PUT", "campaign/" + encodeURIComponent(name), file));
  say(problems.filter(Boolean).join(" "));
}

async function within(folder, above = "") {
  const reader = folder.createReader(), found = [];
  for (;;) {
    const some = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (!some.length) return found;
    for (const one of some)
      found.push(...one.isDirectory ? await within(one, `${above}${one.name}/`) : [[above + one.name, await new Promise((done, failed) => one.file(done, failed))]]);
  }
}

async function dropped(data) {
  const entries = [...data.items].map(item => item.webkitGetAsEntry?.()), files = [...data.files].filter((_, place) => !entries[place]?.isDirectory);
  for (const folder of entries.filter(one => one?.isDirectory)) await putFolder(await within(folder));
  if (files.length) await put(files);
}

function option(one) {
  const units = UNITS[one.hint], asked = one.flag === "--kind";
  const input = one.choices
    ? made("select", {}, made("option", { value: "", textContent: asked ? "choose" : "as it is" }), ...one.choices.map(c => made("option", { value: c, textContent: (asked && KINDS[c]) || c })))
    : made("input", one.hint === null ? { type: "checkbox" } : { type: "text", placeholder: units ? "" : one.hint.replace(/^(integer|float)( range)?$/, "number") });
  input.dataset.flag = one.flag;
  if (asked) return sketched(input);
  const menu = units ? [made("select", { className: "unit" }, ...Object.entries(units).map(([textContent, value]) => made("option", { textContent, value })))] : [];
  return made("label", {}, input, ...menu, `${named(one.flag)}: ${forPage(one.help)}`);
}

// The kinds of contact, to be chosen by their sketches; `select` holds the choice.
function sketched(select) {
  const cards = Object.entries(KINDS).map(([kind, name]) => {
    const card = made("button", { type: "button", className: "kind", innerHTML: `<svg viewBox="0 0 96 60" aria-hidden="true">${SKETCHES[kind]}</svg>${name}` });
    card.onclick = () => { select.value = kind; select.dispatchEvent(new Event("change", { bubbles: true })); };
    select.addEventListener("change", () => card.setAttribute("aria-pressed", select.value === kind));
    return card;
  });
  select.hidden = true;
  return made("div", { className: "kinds" }, made("p", { textContent: "What touches? Choose it first." }), select, ...cards);
}

// A step that asks for the kind of contact waits until it is chosen, and then shows what that kind has.
function fitKind(parts) {
  const kind = parts.own.querySelector("[data-flag='--kind']");
  if (!kind) return true;
  for (const input of parts.own.querySelectorAll("[data-flag]"))
    input.parentElement.hidden = !!kind.value && !(ONLY[input.dataset.flag] ?? [kind.value]).includes(kind.value);
  return !!kind.value;
}

// The value in the unit that the command takes; what is no number stays as it is, to be refused.
function inUnits(input) {
  const factor = Number(input.parentElement.querySelector(".unit")?.value ?? 1), number = Number(input.value.replace(",", "."));
  return factor === 1 || !input.value.trim() || Number.isNaN(number) ? input.value : String(Number((number * factor).toPrecision(12)));
}

function chosen(section) {
  const values = {};
  for (const input of section.querySelectorAll("[data-flag]"))
    if (!input.parentElement.hidden) values[input.dataset.flag] = input.type === "checkbox" ? input.checked : inUnits(input);
  return JSON.stringify(values);
}

function section(step) {
  const own = made("section", { className: "step", id: "step-" + step.name });
  const parts = {
    own, begin: made("button", { type: "button", textContent: "Go" }), end: made("button", { type: "button", textContent: "Stop" }),
    state: made("span", { className: "note" }), bar: made("progress", { max: 1 }), text: made("pre"), left: made("div"), edit: null, seen: "",
  };
  parts.begin.onclick = async () => {
    if (parts.edit && parts.edit.dataset.changed && await save(parts)) return;
    ask("PUT", "steps/" + step.name, chosen(own));
  };
  parts.end.onclick = () => ask("PUT", "stop");
  own.onchange = () => ask("GET", "state");
  own.append(made("h2", { textContent: step.title }), parts.begin, parts.end, parts.state, parts.bar);
  if (step.options.length) own.append(made("details", { open: step.command === "new" }, made("summary", { textContent: "options" }), made("div", { className: "options" }, ...step.options.map(option))));
  own.append(parts.text, parts.left);
  if (step.name === "look") {
    parts.edit = made("textarea", { spellcheck: false, oninput: () => { parts.edit.dataset.changed = "yes"; } });
    parts.units = made("div", { className: "options" });
    own.append(made("details", { open: true }, made("summary", { textContent: "columns and their units" }), parts.units),
      made("details", {}, made("summary", { textContent: "the mapping, which you may edit" }), parts.edit));
  }
  return parts;
}

// A menu for the unit of each column that the mapping names with one; what is chosen is written into the mapping.
function showUnits(parts) {
  if (parts.read === parts.edit.value) return;
  parts.read = parts.edit.value;
  const columns = [...parts.read.matchAll(/^(\w+?)_([A-Za-z]+) = \{ column = ("[^"]*"|\d+), unit = "([^"]*)"/gm)];
  parts.units.replaceChildren(...columns.map(([line, name, kept, column, unit]) => {
    const menu = made("select", {}, ...new Set([unit, ...units[kept] ?? []]).values().map(textContent => made("option", { textContent })));
    menu.onchange = event => {
      event.stopPropagation();
      parts.edit.value = parts.edit.value.replace(line, line.replace(/unit = "[^"]*"$/, `unit = "${menu.value}"`));
      parts.edit.dataset.changed = "yes";
      showUnits(parts);
    };
    return made("label", {}, menu, `${name.replaceAll("_", " ")}: column ${column.replaceAll('"', "")}`);
  }));
}

// Of a run, decades of its cycles that are done; of other work the bar shows only that it goes on.
function showProgress(parts, step, running) {
  const now = running ? step.lines.findLast(line => line.startsWith("wirewear: ")) ?? "" : "";
  const [, done, all] = (/cycle (\d+(?:\s\d{3})*) of (\d+(?:\s\d{3})*)/.exec(now) ?? []).map(one => Number(one.replace(/\s/g, "")));
  if (all > 1) parts.bar.value = Math.log(done) / Math.log(all); else parts.bar.removeAttribute("value");
  parts.bar.hidden = !running;
  const words = [WORDS[step.state], step.seconds === null ? "" : `${step.seconds} s`, now.replace("wirewear: ", "")];
  parts.state.textContent = words.filter(Boolean).join(", ");
}

async function save(parts) {
  const text = parts.edit.value, problem = await ask("PUT", "mapping", text);
  if (!problem && parts.edit.value === text) delete parts.edit.dataset.changed;
  return problem;
}

function show(state) {
  find("folder").textContent = state.folder;
  const opened = Object.entries(state.opened).map(([what, path]) => `${what}: ${path}`);
  find("files").textContent = [...opened, ...state.files].join(" · ");
  for (const step of state.steps) titles[step.command] ??= step.title;
  for (const step of state.steps) {
    if (!shown.has(step.name)) {
      shown.set(step.name, section(step));
      find("steps").append(...state.steps.filter(one => shown.has(one.name)).map(one => shown.get(one.name).own));
    }
    const parts = shown.get(step.name), running = step.state === "running";
    parts.begin.disabled = !fitKind(parts) || !step.ready || state.steps.some(one => one.state === "running");
    parts.end.hidden = !running;
    showProgress(parts, step, running);
    parts.text.hidden = !step.lines.length;
    parts.text.classList.toggle("said", step.state === "failed");
    const text = forPage(step.lines.join("\n"));
    if (parts.text.textContent !== text) { parts.text.textContent = text; parts.text.scrollTop = parts.text.scrollHeight; }
    if (parts.edit && !parts.edit.dataset.changed && state.mapping !== null) parts.edit.value = state.mapping;
    if (parts.edit) showUnits(parts);
    const left = running ? "" : step.left.join("\n") + step.seconds;
    if (left === parts.seen) continue;
    parts.seen = left;
    parts.left.replaceChildren(...(running ? [] : step.left.map(path => {
      const href = "out/" + path.split("/").map(encodeURIComponent).join("/");
      const kept = made("a", { href, download: path.replaceAll("/", "_"), textContent: path.endsWith(".png") ? `save ${path}` : path });
      if (path.endsWith(".html")) return made("p", {}, made("a", { href, target: "_blank", textContent: path }));
      return path.endsWith(".png") ? made("figure", {}, made("img", { src: href + "?" + step.seconds, alt: path }), kept) : made("p", {}, "save ", kept);
    })));
  }
}

const drop = find("drop");
drop.ondragover = event => { event.preventDefault(); drop.classList.add("over"); };
drop.ondragleave = () => drop.classList.remove("over");
drop.ondrop = event => { event.preventDefault(); drop.classList.remove("over"); dropped(event.dataTransfer); };
find("choose").onchange = event => put(event.target.files);
find("choose-folder").onchange = event => putFolder([...event.target.files].map(file => [file.webkitRelativePath.replace(/^[^/]*\//, ""), file]));
const { units, ...first } = JSON.parse(find("data").textContent);
show(first);
setInterval(() => ask("GET", "state"), 1000);
