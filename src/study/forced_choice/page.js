"use strict";

// Milliseconds, as in Anson et al. 2006.
const SHOWN = 4000;
const GREY = 2000;
const BESIDE = 8000;
const GAP = 16; // pixels between pictures, as in the style

const CONDITIONS = {
  successive: {
    sides: ["first", "second"],
    question: "Which of the two pictures was at full quality?",
    across: 1,
  },
  reference: {
    sides: ["left", "right"],
    question: "Which of the lower two was the same as the one on top?",
    across: 2,
  },
};

const $ = (id) => document.getElementById(id);
const served = location.protocol.startsWith("http");
const pictures = new Map(); // of a scene's name: its two decoded pictures
let session = null;

/** A whole number below `n` without bias. */
function lot(n) {
  const limit = Math.floor(2 ** 32 / n) * n;
  for (;;) {
    const [value] = crypto.getRandomValues(new Uint32Array(1));
    if (value < limit) return value % n;
  }
}

/** `items` in random order (Fisher and Yates). */
function shuffled(items) {
  const all = [...items];
  for (let i = all.length - 1; i > 0; i--) {
    const j = lot(i + 1);
    [all[i], all[j]] = [all[j], all[i]];
  }
  return all;
}

function turnTo(state) {
  for (const page of document.querySelectorAll("main")) page.hidden = page.id !== state;
  document.body.dataset.state = state;
}

const pass = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** By how much pictures must shrink to fit into the window. */
function fit(scene, across) {
  const needed = [across * (scene.width + GAP) + GAP, across * (scene.height + GAP) + GAP];
  return Math.min(1, innerWidth / needed[0], innerHeight / needed[1]);
}

function warnIfSmall() {
  const chosen = $("condition").value;
  const ways = chosen === "random" ? Object.keys(CONDITIONS) : [chosen];
  const across = Math.max(...ways.map((way) => CONDITIONS[way].across));
  const small = SCENES.some((scene) => fit(scene, across) < 1);
  $("small").hidden = !small;
  if (!small) return;
  const most = (side) => across * (Math.max(...SCENES.map((scene) => scene[side])) + GAP) + GAP;
  $("small").textContent = "This window is too small to show every pixel: pictures will be shrunk. "
    + `It should have ${most("width")} x ${most("height")} pixels.`;
}

function shown(scene, which) {
  const image = pictures.get(scene.name)[which];
  const scale = fit(scene, CONDITIONS[session.condition].across);
  image.width = Math.floor(scene.width * scale);
  image.height = Math.floor(scene.height * scale);
  return image;
}

function row(...images) {
  const line = document.createElement("div");
  line.className = "row";
  line.append(...images);
  return line;
}

function begin(event) {
  event.preventDefault();
  const participant = $("participant").value.trim();
  if (!participant) return;
  const asked = $("condition").value;
  const condition = asked === "random" ? Object.keys(CONDITIONS)[lot(2)] : asked;
  session = { participant, condition, order: shuffled(SCENES), at: 0, answers: [], unsent: 0 };
  show();
}

/** Shows the pictures of the scene that is next, then asks. */
async function show() {
  const scene = session.order[session.at];
  const { sides } = CONDITIONS[session.condition];
  const order = shuffled(["gold", "directed"]);
  session.trial = { scene: scene.name, gold: sides[order.indexOf("gold")] };
  const stage = $("stage");
  turnTo("stage");
  if (session.condition === "successive") {
    stage.replaceChildren(row(shown(scene, order[0])));
    await pass(SHOWN);
    stage.replaceChildren();
    await pass(GREY);
    stage.replaceChildren(row(shown(scene, order[1])));
    await pass(SHOWN);
  } else {
    const top = shown(scene, "gold").cloneNode();
    await top.decode();
    stage.replaceChildren(row(top), row(shown(scene, order[0]), shown(scene, order[1])));
    await pass(BESIDE);
  }
  stage.replaceChildren();
  ask();
}

function ask() {
  const { sides, question } = CONDITIONS[session.condition];
  $("asked").textContent = question;
  ["a", "b"].forEach((id, index) => { $(id).textContent = `${index + 1}: ${sides[index]}`; });
  session.trial.asked = performance.now();
  turnTo("question");
}

async function choose(index) {
  if (document.body.dataset.state !== "question") return;
  turnTo("storing");
  const { scene, gold, asked } = session.trial;
  const answer = {
    participant: session.participant,
    scene,
    condition: session.condition,
    gold,
    chosen: CONDITIONS[session.condition].sides[index],
    seconds: Math.round(performance.now() - asked) / 1000,
    time: new Date().toISOString(),
  };
  session.answers.push(answer);
  if (served) await send(answer);
  session.at += 1;
  if (session.at === session.order.length) {
    finish();
  } else {
    $("told").textContent = `${session.at} of ${session.order.length} done.`;
    turnTo("pause");
  }
}

async function send(answer) {
  try {
    const reply = await fetch("/answers", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(answer),
    });
    if (reply.ok) return;
    session.problem = await reply.text();
  } catch (problem) {
    session.problem = String(problem);
  }
  session.unsent += 1;
}

/** The session's answers as the file that `fogbow trial --analyse` reads. */
function csv() {
  const field = (value) => {
    const text = String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const line = (values) => values.map(field).join(",");
  const rows = session.answers.map((answer) => line(COLUMNS.map((name) => answer[name])));
  return [line(COLUMNS), ...rows, ""].join("\n");
}

function finish() {
  const stored = served && session.unsent === 0;
  const link = $("download");
  link.hidden = stored;
  if (stored) {
    $("kept").textContent = "Your answers are stored.";
  } else {
    const why = session.problem ? `Not all answers could be stored: ${session.problem}. ` : "";
    $("kept").textContent = `${why}Please download your answers and hand them over.`;
    link.href = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
    link.download = `answers-${session.participant.replaceAll(/[^\w-]/g, "_")}.csv`;
  }
  turnTo("done");
}

function next() {
  if (document.body.dataset.state === "pause") show();
}

function welcome() {
  const bytes = crypto.getRandomValues(new Uint8Array(4));
  $("participant").value = [...bytes].map((b) => b.toString(16).padStart(2, "0")).join("");
  warnIfSmall();
  turnTo("start");
}

$("form").addEventListener("submit", begin);
$("condition").addEventListener("change", warnIfSmall);
addEventListener("resize", warnIfSmall);
$("a").addEventListener("click", () => choose(0));
$("b").addEventListener("click", () => choose(1));
$("next").addEventListener("click", next);
$("again").addEventListener("click", welcome);
const CHOICES = { 1: 0, 2: 1, ArrowLeft: 0, ArrowRight: 1 };
addEventListener("keydown", (event) => {
  const { state } = document.body.dataset;
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
  if (state === "question" && event.key in CHOICES) {
    event.preventDefault();
    choose(CHOICES[event.key]);
  } else if (state === "pause" && (event.key === " " || event.key === "ArrowRight")) {
    event.preventDefault();
    next();
  }
});

async function load() {
  for (const scene of SCENES) {
    const both = {};
    for (const which of ["gold", "directed"]) {
      both[which] = new Image();
      both[which].src = scene[which];
      await both[which].decode();
    }
    pictures.set(scene.name, both);
  }
  welcome();
}
load();
