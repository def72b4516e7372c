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
// Units by what a command calls a value; what the kinds of contact are called, and options that only some of them have.
const UNITS = { MM: "mm", UM: "µm", N: "N", HZ: "Hz", DEG: "°", GB: "GB", MPa: "MPa", UM_PER_N: "µm/N", mm3: "mm³", "mm3/J": "mm³/J" };
const KINDS = { "crossed-wires": "two wires that cross", "ball-on-flat": "ball on flat", "cylinder-on-flat": "cylinder on flat",
  "line-contact": "flat with rounded edges on flat", "point-contact": "two other bodies",
  joint: "a joint, by its loops alone" };
const LINES = ["cylinder-on-flat", "line-contact"];
const ONLY = { "--length": LINES, "--radius": LINES, "--face-half-width": LINES, "--edge-radius": LINES, "--pad-material": [...LINES, "ball-on-flat"],
  "--material": Object.keys(KINDS).filter(one => one !== "joint"), "--diameter": ["crossed-wires", "ball-on-flat"], "--crossing-angle": ["crossed-wires"] };
const named = flag => flag.replace(/^-+/, "").replaceAll("-", " ");
// On a page, an option of the command line is a field.
const forPage = text => text.replace(/--([a-z][a-z-]*)/g, (_, name) => `“${named(name)}”`);

const ENDED = "wirewear has ended: begin `wirewear open` again.";
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

function option(one) {
  const unit = UNITS[one.hint], asked = one.flag === "--kind";
  const input = one.choices
    ? made("select", {}, made("option", { value: "", textContent: asked ? "choose" : "as it is" }), ...one.choices.map(c => made("option", { value: c, textContent: (asked && KINDS[c]) || c })))
    : made("input", one.hint === null ? { type: "checkbox" } : { type: "text", placeholder: unit ? "" : one.hint.replace(/^(integer|float)( range)?$/, "number") });
  input.dataset.flag = one.flag;
  return made("label", {}, input, `${asked ? "what touches" : named(one.flag)}${unit ? ` [${unit}]` : ""}: ${asked ? "choose it first." : forPage(one.help)}`);
}

// A step that asks for the kind of contact waits until it is chosen, and then shows what that kind has.
function fitKind(parts) {
  const kind = parts.own.querySelector("[data-flag='--kind']");
  if (!kind) return true;
  for (const input of parts.own.querySelectorAll("[data-flag]"))
    input.parentElement.hidden = !!kind.value && !(ONLY[input.dataset.flag] ?? [kind.value]).includes(kind.value);
  return !!kind.value;
}

function chosen(section) {
  const values = {};
  for (const input of section.querySelectorAll("[data-flag]"))
    if (!input.parentElement.hidden) values[input.dataset.flag] = input.type === "checkbox" ? input.checked : input.value;
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
  if (step.options.length) own.append(made("details", { open: step.name === "guess" }, made("summary", { textContent: "options" }), made("div", { className: "options" }, ...step.options.map(option))));
  own.append(parts.text, parts.left);
  if (step.name === "look") {
    parts.edit = made("textarea", { spellcheck: false, oninput: () => { parts.edit.dataset.changed = "yes"; } });
    own.append(made("details", {}, made("summary", { textContent: "the mapping, which you may edit" }), parts.edit));
  }
  find("steps").append(own);
  return parts;
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
  for (const step of state.steps) {
    if (!shown.has(step.name)) shown.set(step.name, section(step));
    const parts = shown.get(step.name), running = step.state === "running";
    parts.begin.disabled = !fitKind(parts) || !step.ready || state.steps.some(one => one.state === "running");
    parts.end.hidden = !running;
    showProgress(parts, step, running);
    parts.text.hidden = !step.lines.length;
    parts.text.classList.toggle("said", step.state === "failed");
    const text = forPage(step.lines.join("\n"));
    if (parts.text.textContent !== text) { parts.text.textContent = text; parts.text.scrollTop = parts.text.scrollHeight; }
    if (parts.edit && !parts.edit.dataset.changed && state.mapping !== null) parts.edit.value = state.mapping;
    const left = running ? "" : step.left.join("\n") + step.seconds;
    if (left === parts.seen) continue;
    parts.seen = left;
    parts.left.replaceChildren(...(running ? [] : step.left.map(path => {
      const href = "out/" + path.split("/").map(encodeURIComponent).join("/");
      return path.endsWith(".html") ? made("p", {}, made("a", { href, target: "_blank", textContent: path }))
        : made("img", { src: href + "?" + step.seconds, alt: path });
    })));
  }
}

const drop = find("drop");
drop.ondragover = event => { event.preventDefault(); drop.classList.add("over"); };
drop.ondragleave = () => drop.classList.remove("over");
drop.ondrop = event => { event.preventDefault(); drop.classList.remove("over"); put(event.dataTransfer.files); };
find("choose").onchange = event => put(event.target.files);
show(JSON.parse(find("data").textContent));
setInterval(() => ask("GET", "state"), 1000);
