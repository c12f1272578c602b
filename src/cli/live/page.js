"use strict";

const $ = (id) => document.getElementById(id);
const CONTROLS = ["layer", "exposure", "transform", "reset"];

/** Stops that the exposure reaches up and down from the scene's. */
const REACH = 8;

/** The window up to which the picture stands above the controls, as in the style. */
const narrow = matchMedia("(max-width: 800px)");

let status = null; // what the server told last
let scenes = null; // the view of the scene, as text

/** Sets text only where it differs, so that nothing is read aloud twice. */
function write(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

/** The same for a text with paths, whose lines break after slashes. */
function writePath(id, text) {
  if ($(id).textContent === text) return;
  const parts = text.split(/(?<=\/)/);
  $(id).replaceChildren(...parts.flatMap((part) => [part, document.createElement("wbr")]));
}

/** Four digits of a number. */
function number(text) {
  const value = Number(text);
  const plain = value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5);
  return plain ? String(Number(value.toPrecision(4))) : value.toExponential(2);
}

/** Shows the picture pixel by pixel, enlarged by whole numbers or shrunk to what there is room for. */
function fit() {
  const canvas = $("canvas");
  const room = [$("stage").clientWidth, narrow.matches ? 0.6 * innerHeight : $("stage").clientHeight];
  const most = Math.min(room[0] / canvas.width, room[1] / canvas.height);
  const scale = most < 1 ? most : Math.floor(most);
  canvas.style.width = `${scale * canvas.width}px`;
  canvas.style.height = `${scale * canvas.height}px`;
  canvas.classList.toggle("enlarged", scale > 1);
}

function tellStops() {
  const stops = Number($("exposure").value);
  write("stops", `${stops > 0 ? "+" : stops < 0 ? "\u2212" : ""}${Math.abs(stops).toFixed(2)} stops`);
}

/** The scene's own exposure and view transform. */
function reset() {
  const { exposure, transform } = status.view;
  Object.assign($("exposure"), { min: exposure - REACH, max: exposure + REACH, value: exposure });
  $("transform").value = transform;
  tellStops();
}

function tellLayers() {
  const names = status.layers.map(([name]) => name);
  const shown = [...$("layer").options].map((option) => option.value);
  if (names.length === 0 || names.join() === shown.join()) return;
  const chosen = $("layer").value;
  $("layer").replaceChildren(...status.layers.map(([name, title]) => new Option(title, name)));
  $("layer").value = names.includes(chosen) ? chosen : names[0];
  tellWays();
}

/** Exposure and transform are those of pictures; other layers have a scale. */
function tellWays() {
  const isPicture = ["beauty", "noisy"].includes($("layer").value);
  $("developed").hidden = !isPicture;
  $("scale").hidden = isPicture;
}

function tellStage() {
  const { stage, loaded } = status;
  const share = stage ? stage.share : 0;
  const percent = `${Math.floor(100 * share)} %`;
  write("now", stage ? stage.name : loaded ? "between two stages" : "loading");
  write("percent", stage ? percent : "");
  $("bar").value = share;
  write("worked", stage ? `${stage.worked} so far` : "");
  write("left", stage && stage.left ? `about ${stage.left} left` : "");
  document.title = stage ? `${percent} ${stage.name} - ${status.name}` : `${status.name} - fogbow`;
}

function tellError() {
  const { error } = status;
  $("error").hidden = !error;
  if (!error) return;
  write("reached", error.reached ?? "not known yet");
  write("goal", error.goal);
  write("rays", error.rays.toLocaleString("en"));
  write("photons", error.photons.toLocaleString("en"));
}

function tell() {
  writePath("name", status.name);
  const view = JSON.stringify(status.view);
  if (status.loaded && view !== scenes) {
    scenes = view;
    reset();
  }
  if (status.version > 0) {
    for (const id of CONTROLS) $(id).disabled = false;
  }
  tellLayers();
  tellStage();
  tellError();
  if (status.size) write("facts", `${status.size.join(" x ")} pixels, picture ${status.version}`);
}

/** The newest picture as the controls ask for it. */
async function load() {
  const query = new URLSearchParams({ version: status.version });
  for (const id of ["layer", "exposure", "transform"]) query.set(id, $(id).value);
  const reply = await fetch(`picture?${query}`);
  if (!reply.ok) return;
  const bitmap = await createImageBitmap(await reply.blob());
  const canvas = $("canvas");
  [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
  canvas.getContext("2d").drawImage(bitmap, 0, 0);
  $("empty").hidden = true;
  canvas.hidden = false;
  canvas.setAttribute("aria-label", `${status.name}, ${$("layer").selectedOptions[0].text}`);
  fit();
  const range = reply.headers.get("X-Range");
  const [low, high] = range ? range.split(" ") : ["", ""];
  write("low", range ? number(low) : "");
  write("high", range ? number(high) : "");
  document.body.dataset.version = reply.headers.get("X-Version");
  document.body.dataset.shown = `${query}`;
}

let drawing = null;
let isStale = false;

/** Draws the newest picture, one after the other; of several that are asked for meanwhile only the last one. */
function draw() {
  if (!status || status.version === 0) return null;
  isStale = true;
  drawing ??= (async () => {
    try {
      while (isStale) {
        isStale = false;
        await load();
      }
    } catch {
      // The server has ended, of which the next question for news tells.
    }
    drawing = null;
  })();
  return drawing;
}

/** The picture stays; there is nobody left to develop it in another way. */
function end(how, words) {
  for (const id of CONTROLS) $(id).disabled = true;
  document.body.dataset.state = "ended";
  $("progress").hidden = true;
  $("told").hidden = false;
  writePath("told", words);
  document.title = `${how} - ${status ? status.name : "fogbow"}`;
}

async function follow() {
  let seen = "";
  for (;;) {
    try {
      status = await (await fetch(`state?seen=${seen}`)).json();
    } catch {
      end("ended", "fogbow does not answer: it was ended or has failed. Its messages say why.");
      return;
    }
    tell();
    if (status.version !== seen && status.version > 0) {
      document.body.dataset.state = "rendering";
      draw();
    }
    seen = status.version;
    if (status.ended !== null) {
      await (drawing ?? draw());
      if (status.ended === "finished") end("finished", `Finished: ${status.name} is written.`);
      else end("ended", status.ended[0].toUpperCase() + status.ended.slice(1));
      return;
    }
  }
}

for (const id of ["layer", "exposure", "transform"]) {
  $(id).addEventListener("input", () => {
    tellStops();
    tellWays();
    draw();
  });
}
$("reset").addEventListener("click", () => {
  reset();
  draw();
});
addEventListener("resize", fit);
follow();
