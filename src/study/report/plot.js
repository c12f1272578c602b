// Error against run time between logarithmic axes. What is chosen in the legend has one of seven hues
// and a mark of its own, the rest is grey.
const HUES = 7;
const MARKS = [
  (r) => `M${-r},0a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${-2 * r},0z`,
  (r) => `M${-r},${-r}H${r}V${r}H${-r}z`,
  (r) => `M0,${-1.3 * r}L${1.2 * r},${r}H${-1.2 * r}z`,
  (r) => `M0,${-1.4 * r}L${1.4 * r},0L0,${1.4 * r}L${-1.4 * r},0z`,
  (r) => `M0,${1.3 * r}L${1.2 * r},${-r}H${-1.2 * r}z`,
  (r) => `M${-r},${-0.4 * r}H${-0.4 * r}V${-r}H${0.4 * r}V${-0.4 * r}H${r}V${0.4 * r}H${0.4 * r}V${r}H${-0.4 * r}V${0.4 * r}H${-r}z`,
  (r) => `M${-1.3 * r},0L${-0.6 * r},${-1.1 * r}H${0.6 * r}L${1.3 * r},0L${0.6 * r},${1.1 * r}H${-0.6 * r}z`,
];
const GOLD = { color: "var(--ink)", mark: (r) => MARKS[3](1.3 * r) };
const hueOf = new Map(); // of a candidate's name: its hue

function look(name) {
  if (name === "gold") return GOLD;
  const hue = hueOf.get(name);
  return hue === undefined ? null : { color: `var(--hue-${hue})`, mark: MARKS[hue] };
}

function choose(name, chosen) {
  if (!chosen) {
    hueOf.delete(name);
    return;
  }
  const used = new Set(hueOf.values());
  const free = [...Array(HUES).keys()].find((hue) => !used.has(hue));
  if (free !== undefined) hueOf.set(name, free);
}

function svg(name, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** Powers of ten, with their doubles and fives where there are few. */
function ticks([low, high], most) {
  const powers = [];
  for (let p = Math.floor(Math.log10(low)); p <= Math.ceil(Math.log10(high)); p++) powers.push(p);
  const at = (steps) => powers.flatMap((p) => steps.map((s) => s * 10 ** p))
    .filter((v) => v >= low * 0.9999 && v <= high * 1.0001);
  const choices = [[1, 1.5, 2, 3, 4, 5, 6, 8], [1, 2, 3, 5], [1, 2, 5], [1, 3], [1]].map(at);
  return choices.find((all) => all.length <= most) ?? choices.at(-1);
}

function figure(value) {
  if (value >= 1e4 || value < 1e-3) {
    const [digits, power] = value.toExponential(3).split("e");
    const raised = [...power.replace("+", "")].map((c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻").join("");
    const lead = Number(digits);
    return lead === 1 ? `10${raised}` : `${lead}·10${raised}`;
  }
  return String(Number(value.toPrecision(3)));
}

function drawPlot() {
  const plot = PLOTS.metrics[Number($("metric").value)];
  const width = $("plot").clientWidth;
  if (width === 0) return; // not laid out yet
  const height = width < 600 ? Math.round(width * 0.95) : Math.min(440, Math.round(width * 0.5));
  const box = { left: 62, top: 30, right: width - (width < 600 ? 12 : 96), bottom: height - 42 };
  const all = plot.series.flatMap((series) => series.points);
  const ends = (values, margin) => [Math.min(...values) / margin, Math.max(...values) * margin];
  const xs = ends(all.map((p) => p.x), 1.25);
  const ys = ends([...all.map((p) => p.y), ...(plot.own ? [plot.own] : [])], 1.4);
  const along = ([low, high], from, to) => (value) => {
    const share = Math.log(value / low) / Math.log(high / low);
    return from + (to - from) * Math.min(1, Math.max(0, share));
  };
  const [x, y] = [along(xs, box.left, box.right), along(ys, box.bottom, box.top)];
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, height, role: "img",
    "aria-label": `${plot.title} against run time; every figure is in the table of all candidates` });
  for (const tick of ticks(ys, height < 400 ? 7 : 9)) {
    root.append(svg("line", { class: "grid", x1: box.left, x2: box.right, y1: y(tick), y2: y(tick) }),
      svg("text", { x: box.left - 8, y: y(tick) + 4, "text-anchor": "end" }, figure(tick)));
  }
  for (const tick of ticks(xs, Math.floor(width / 75))) {
    root.append(svg("line", { class: "grid", x1: x(tick), x2: x(tick), y1: box.top, y2: box.bottom }),
      svg("text", { x: x(tick), y: box.bottom + 18, "text-anchor": "middle" }, figure(tick)));
  }
  root.append(
    svg("rect", { id: "data", x: box.left, y: box.top, width: box.right - box.left,
      height: box.bottom - box.top, fill: "none" }),
    svg("line", { class: "axis", x1: box.left, x2: box.right, y1: box.bottom, y2: box.bottom }),
    svg("text", { x: box.left, y: 14 }, `${plot.title} against the ${PLOTS.target}`),
    svg("text", { x: box.right, y: height - 6, "text-anchor": "end" }, "run time in seconds"),
  );
  if (plot.own) {
    root.append(svg("line", { class: "own", x1: box.left, x2: box.right, y1: y(plot.own), y2: y(plot.own) }));
  }
  const line = (points) => `M${points.map((p) => `${x(p.x)},${y(p.y)}`).join("L")}`;
  const labels = [];
  const chosen = plot.series.filter((series) => look(series.name));
  for (const { name, points } of plot.series.filter((series) => !look(series.name))) {
    root.append(svg("path", { class: "rest", d: line(points) }, svg("title", {}, name)));
  }
  for (const { name, points } of chosen) {
    const { color, mark } = look(name);
    const group = svg("g", { class: "chosen", stroke: color, fill: color });
    for (const p of points) {
      if (p.xr) group.append(svg("path", { class: "range", d: `M${x(p.xr[0])},${y(p.y)}H${x(p.xr[1])}` }));
      if (p.yr) group.append(svg("path", { class: "range", d: `M${x(p.x)},${y(p.yr[0])}V${y(p.yr[1])}` }));
    }
    group.append(svg("path", { class: "series", d: line(points) }));
    for (const p of points) {
      group.append(svg("path", { d: mark(4.2), transform: `translate(${x(p.x)},${y(p.y)})`, stroke: "none" },
        svg("title", {}, `${name}, ${p.label}: ${figure(p.y)} in ${figure(p.x)} s`)));
    }
    root.append(group);
    const end = points.reduce((a, b) => (b.x > a.x ? b : a));
    labels.push({ name, x: x(end.x), y: y(end.y) });
  }
  placeLabels(root, labels, box);
  $("plot").replaceChildren(root);
}

/** Names at the ends of their lines, moved up and down until none is over another. */
function placeLabels(root, labels, box) {
  const size = (label) => 6.9 * label.name.length;
  labels.sort((a, b) => a.y - b.y);
  const placed = [];
  for (const label of labels) {
    const inside = label.x + 10 + size(label) < box.right + 92 && box.right + 92 < root.viewBox.baseVal.width;
    const left = inside ? label.x + 10 : Math.max(box.left + 2, label.x - 10 - size(label));
    let top = label.y + 4;
    const hits = () => placed.some((other) => Math.abs(other.top - top) < 14
      && left < other.left + other.width && other.left < left + size(label));
    while (hits()) top += 2;
    if (top > box.bottom - 2) {
      top = label.y + 4;
      while (hits()) top -= 2;
    }
    placed.push({ left, top, width: size(label) });
    root.append(svg("text", { class: "name", x: left, y: top }, label.name));
  }
}

function drawLegend() {
  const series = PLOTS.metrics[0].series;
  const rows = series.map(({ name, about }) => {
    const input = Object.assign(document.createElement("input"), { type: "checkbox", value: name });
    input.checked = look(name) !== null;
    const key = svg("svg", { viewBox: "0 0 22 14", "aria-hidden": "true" });
    const row = document.createElement("label");
    row.title = about;
    row.append(input, key, name);
    input.addEventListener("change", () => {
      choose(name, input.checked);
      update();
      drawPlot();
    });
    if (name === "gold") input.disabled = true;
    return { row, input, key, name };
  });
  const update = () => rows.forEach(({ input, key, name }) => {
    const shown = look(name);
    input.disabled = name === "gold" || (!shown && hueOf.size >= HUES);
    const color = shown?.color ?? "var(--faint)";
    key.replaceChildren(svg("path", { d: "M0,7H22", style: `stroke: ${color}; stroke-width: 2` }));
    if (shown) {
      key.append(svg("path", { d: shown.mark(4), transform: "translate(11,7)", style: `fill: ${color}` }));
    }
  });
  update();
  $("legend").append(...rows.map(({ row }) => row));
}

if (PLOTS.metrics.length > 0) {
  PLOTS.metrics.forEach(({ title }, index) => $("metric").add(new Option(title, index)));
  const names = PLOTS.metrics[0].series.map(({ name }) => name).filter((name) => name !== "gold");
  PLOTS.core.filter((name) => names.includes(name)).forEach((name) => choose(name, true));
  names.filter((name) => !hueOf.has(name)).slice(0, 2).forEach((name) => choose(name, true));
  drawLegend();
  drawPlot();
  $("metric").addEventListener("change", drawPlot);
  onWidth($("plot"), drawPlot);
} else {
  document.querySelector(".chart").hidden = true;
}
