// The viewer: two pictures of linear radiance at the same place, developed as the scene's film is.
const canvas = $("canvas");
const context = canvas.getContext("2d");
const state = { zoom: 1, x: 0, y: 0, edge: 0.5, second: false, shown: [null, null] };
const decoded = new Map();

function half(high, low) {
  const exponent = (high >> 2) & 31;
  const mantissa = ((high & 3) << 8) | low;
  return exponent === 0 ? mantissa * 2 ** -24 : (1024 + mantissa) * 2 ** (exponent - 25);
}

async function radiance(index) {
  if (!decoded.has(index)) {
    const view = VIEWS[index];
    const image = new Image();
    image.src = view.png;
    await image.decode();
    const surface = new OffscreenCanvas(view.width, 2 * view.height);
    const drawing = surface.getContext("2d", { willReadFrequently: true });
    drawing.drawImage(image, 0, 0);
    const bytes = drawing.getImageData(0, 0, view.width, 2 * view.height).data;
    const values = new Float32Array(3 * view.width * view.height);
    const lower = 4 * view.width * view.height;
    for (let pixel = 0; pixel < view.width * view.height; pixel++) {
      for (let c = 0; c < 3; c++) {
        values[3 * pixel + c] = half(bytes[4 * pixel + c], bytes[lower + 4 * pixel + c]);
      }
    }
    decoded.set(index, values);
  }
  return decoded.get(index);
}

const encode = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

/** The product of a matrix, by rows, and a vector. */
const times = (m, [a, b, c]) => m.map((row) => row[0] * a + row[1] * b + row[2] * c);

/** AgX as `fogbow render` shows it, from linear radiance to linear display light. */
function agx(rgb) {
  const { to_log, range, sigmoid, outset, to_display } = VIEW.agx;
  const curved = times(to_log, rgb).map((v) => {
    const log = (Math.log2(Math.max(v, 1e-10)) - range[0]) / (range[1] - range[0]);
    const at = Math.min(1, Math.max(0, log));
    return sigmoid.reduce((sum, coefficient) => sum * at + coefficient, 0);
  });
  return times(to_display, times(outset, curved).map((v) => Math.max(0, v) ** 2.2));
}

function developed(view, values) {
  const scale = 2 ** Number($("exposure").value);
  const colours = $("false").checked;
  const image = new ImageData(view.width, view.height);
  for (let pixel = 0; pixel < view.width * view.height; pixel++) {
    const rgb = [0, 1, 2].map((c) => scale * values[3 * pixel + c]);
    const luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    const shown = colours
      ? PALETTE[Math.round(255 * Math.min(1, luminance))]
      : (VIEW.transform === "agx" ? agx(rgb) : rgb)
        .map((v) => 255 * encode(Math.min(1, Math.max(0, v))));
    for (let c = 0; c < 3; c++) image.data[4 * pixel + c] = Math.round(shown[c]);
    image.data[4 * pixel + 3] = 255;
  }
  const surface = new OffscreenCanvas(view.width, view.height);
  surface.getContext("2d").putImageData(image, 0, 0);
  return surface;
}

const mode = () => document.querySelector("input[name=mode]:checked").value;

function draw() {
  canvas.width = canvas.clientWidth;
  canvas.height = canvas.clientHeight;
  context.imageSmoothingEnabled = state.zoom < 1;
  const whole = (surface, left, right) => {
    if (!surface) return;
    context.save();
    context.beginPath();
    context.rect(left, 0, right - left, canvas.height);
    context.clip();
    const { zoom, x, y } = state;
    context.drawImage(surface, x, y, surface.width * zoom, surface.height * zoom);
    context.restore();
  };
  const [a, b] = state.shown;
  if (mode() === "flip") {
    whole(state.second ? b : a, 0, canvas.width);
  } else {
    const edge = Math.round(state.edge * canvas.width);
    whole(a, 0, edge);
    whole(b, edge, canvas.width);
    context.fillStyle = "#fff";
    context.fillRect(edge, 0, 1, canvas.height);
  }
  $("edge").value = String(state.edge);
  $("edge").disabled = mode() === "flip";
  const names = ["a", "b"].map((id) => VIEWS[$(id).value].name);
  context.font = "600 14px system-ui, sans-serif";
  const label = (text, x, y, align) => {
    context.textAlign = align;
    context.fillStyle = "#fff";
    context.strokeStyle = "#000";
    context.lineWidth = 3;
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  };
  if (mode() === "flip") {
    label(`${state.second ? "B" : "A"}: ${names[state.second ? 1 : 0]}`, 12, 24, "left");
  } else {
    label(`A: ${names[0]}`, 12, 24, "left");
    label(`B: ${names[1]}`, canvas.width - 12, canvas.width < 500 ? canvas.height - 12 : 24, "right");
  }
}

function reset() {
  const view = VIEWS[$("a").value];
  state.zoom = Math.min(canvas.clientWidth / view.width, canvas.clientHeight / view.height);
  state.x = (canvas.clientWidth - view.width * state.zoom) / 2;
  state.y = (canvas.clientHeight - view.height * state.zoom) / 2;
  draw();
}

async function develop() {
  $("stops").value = `${$("exposure").value} stops`;
  for (const [slot, id] of ["a", "b"].entries()) {
    const index = Number($(id).value);
    state.shown[slot] = developed(VIEWS[index], await radiance(index));
  }
  draw();
}

function flip() {
  state.second = !state.second;
  draw();
}

/** Zooms by `factor` about a place of the canvas. */
function zoom(factor, [x, y]) {
  state.x = x - (x - state.x) * factor;
  state.y = y - (y - state.y) * factor;
  state.zoom *= factor;
  draw();
}

async function readout(event) {
  const place = [(event.offsetX - state.x) / state.zoom, (event.offsetY - state.y) / state.zoom];
  const [x, y] = place.map(Math.floor);
  const view = VIEWS[$("a").value];
  if (x < 0 || y < 0 || x >= view.width || y >= view.height) return;
  const told = await Promise.all(["a", "b"].map(async (id) => {
    const values = await radiance(Number($(id).value));
    const at = 3 * (y * view.width + x);
    return `${id.toUpperCase()} ${[...values.slice(at, at + 3)].map((v) => v.toPrecision(3)).join(" ")}`;
  }));
  $("readout").textContent = `Pixel ${x}, ${y}: ${told.join("; ")}`;
}

for (const id of ["a", "b"]) {
  VIEWS.forEach((view, index) => $(id).add(new Option(view.name, index)));
  $(id).addEventListener("change", develop);
}
const viewOf = (name) => VIEWS.findIndex((view) => view.name.startsWith(`${name}, `));
$("a").value = String(Math.max(0, viewOf("gold")));
const rival = viewOf(PLOTS.core[0]);
$("b").value = String(rival < 0 ? VIEWS.length - 1 : rival);
$("exposure").addEventListener("input", develop);
$("false").addEventListener("change", develop);
$("edge").addEventListener("input", () => {
  state.edge = Number($("edge").value);
  draw();
});
$("flip").addEventListener("click", () => {
  document.querySelector("input[value=flip]").checked = true;
  flip();
});
$("reset").addEventListener("click", reset);
document.querySelectorAll("input[name=mode]").forEach((radio) => radio.addEventListener("change", draw));
canvas.addEventListener("keydown", (event) => {
  const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
  const keys = {
    " ": () => (mode() === "flip" ? flip() : $("flip").click()),
    ArrowLeft: () => { state.edge = Math.max(0, state.edge - 0.02); draw(); },
    ArrowRight: () => { state.edge = Math.min(1, state.edge + 0.02); draw(); },
    "+": () => zoom(1.25, middle),
    "-": () => zoom(0.8, middle),
  };
  if (!keys[event.key] || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  keys[event.key]();
});
let grip = null;
canvas.addEventListener("pointerdown", (event) => {
  grip = { x: event.offsetX, y: event.offsetY, moved: false };
  canvas.setPointerCapture(event.pointerId);
});
canvas.addEventListener("pointermove", (event) => {
  if (grip && event.pointerType === "mouse") {
    state.x += event.offsetX - grip.x;
    state.y += event.offsetY - grip.y;
    grip = { x: event.offsetX, y: event.offsetY, moved: true };
  } else {
    state.edge = Math.min(1, Math.max(0, event.offsetX / canvas.clientWidth));
  }
  readout(event);
  draw();
});
canvas.addEventListener("pointerup", () => {
  if (grip && !grip.moved && mode() === "flip") flip();
  grip = null;
});
canvas.addEventListener("wheel", (event) => {
  if (!event.ctrlKey) return; // the page scrolls
  event.preventDefault();
  zoom(2 ** (-event.deltaY / 400), [event.offsetX, event.offsetY]);
}, { passive: false });
onWidth(canvas, reset);
develop().then(reset);
