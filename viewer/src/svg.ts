// Pictures of the cover that can be clicked and reached by keys: a learning curve, and who comes from whom.

import type { CurveDoc, Estimate, KeptDoc } from "./contents";

const SVG = "http://www.w3.org/2000/svg";
const ROOM = { left: 52, right: 18, top: 12, bottom: 42 };
const COLUMN = 118; // pixels an iteration of a lineage
const ROW = 44;

function draw(tag: string, traits: Record<string, string | number>, ...children: (Element | string)[]): Element {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(traits)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/** 48000 as "48k". */
export function short(steps: number): string {
  return steps >= 1e6 ? `${Number((steps / 1e6).toFixed(2))}M` : steps >= 1000 ? `${Number((steps / 1000).toFixed(1))}k` : String(steps);
}

/** Round numbers between two values. */
export function ticksOf(low: number, high: number, most: number): number[] {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(Math.max(rough, 1e-9)));
  const step = [1, 2, 2.5, 5, 10].map((one) => one * power).find((one) => one >= rough) ?? power;
  const found: number[] = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9; k++) found.push(Number((k * step).toPrecision(6)));
  return found;
}

export interface Measure {
  name: string;
  of: (row: CurveDoc["rows"][number]) => Estimate;
  range: [number, number];
  text: (value: number) => string;
}

export const WIN_RATE: Measure = { name: "win rate", of: (row) => row[2], range: [0, 1], text: (value) => `${Math.round(100 * value)} %` };
export const MARGIN: Measure = { name: "mean margin", of: (row) => row[3], range: [0, 0], text: (value) => `${value > 0 ? "+" : value < 0 ? "−" : ""}${Math.abs(Math.round(value))}` };

/** A learning curve with its band; points that have a game open it. */
export function curveChart(curve: CurveDoc, measure: Measure, [width, height]: [number, number], open: (game: number) => void): Element {
  const { rows } = curve;
  const all = rows.flatMap((row) => measure.of(row));
  const low = Math.min(measure.range[0], ...all);
  const high = Math.max(measure.range[1], ...all);
  const most = Math.max(1, ...rows.map((row) => row[0]));
  const x = (steps: number) => ROOM.left + (steps / most) * (width - ROOM.left - ROOM.right);
  const y = (value: number) => ROOM.top + ((high - value) / Math.max(1e-9, high - low)) * (height - ROOM.top - ROOM.bottom);
  const line = rows.map((row) => `${x(row[0])},${y(measure.of(row)[0])}`).join(" ");
  const band = [...rows.map((row) => `${x(row[0])},${y(measure.of(row)[2])}`), ...rows.map((row) => `${x(row[0])},${y(measure.of(row)[1])}`).reverse()].join(" ");
  const axes = [
    ...ticksOf(low, high, 4).flatMap((value) => [
      draw("line", { x1: ROOM.left, x2: width - ROOM.right, y1: y(value), y2: y(value), class: "grid" }),
      draw("text", { x: ROOM.left - 8, y: y(value) + 4, "text-anchor": "end" }, measure.text(value)),
    ]),
    ...ticksOf(0, most, width > 420 ? 6 : 4).map((value) => draw("text", { x: x(value), y: height - 22, "text-anchor": "middle" }, short(value))),
    draw("text", { x: (ROOM.left + width - ROOM.right) / 2, y: height - 5, "text-anchor": "middle" }, "env steps"),
  ];
  const points = rows.map((row) => pointOf(row, measure, [x(row[0]), y(measure.of(row)[0])], open));
  const traits = { width, height, viewBox: `0 0 ${width} ${height}`, role: "group", "aria-label": `${measure.name} over env steps` };
  return draw("svg", traits, ...axes, draw("polygon", { points: band, class: "band" }), draw("polyline", { points: line, class: "curve" }), ...points);
}

function pointOf(row: CurveDoc["rows"][number], measure: Measure, [x, y]: [number, number], open: (game: number) => void): Element {
  const [value, low, high] = measure.of(row).map(measure.text);
  const says = `${row[0].toLocaleString("en")} steps: ${measure.name} ${value} [${low}, ${high}]`;
  if (row[1] === 0) return draw("circle", { cx: x, cy: y, r: 3, class: "bare" }, draw("title", {}, says));
  const group = draw("g", { role: "button", tabindex: 0, class: "point", "aria-label": `${says}; opens its game`, "data-game": row[1] }, draw("title", {}, `${says}; opens its game`));
  group.append(draw("circle", { cx: x, cy: y, r: 17, class: "target" }), draw("circle", { cx: x, cy: y, r: 7, class: "dot" }));
  group.addEventListener("click", () => open(row[1]));
  group.addEventListener("keydown", (event) => {
    if (!["Enter", " "].includes((event as KeyboardEvent).key)) return;
    event.preventDefault();
    open(row[1]);
  });
  return group;
}

/** Who was kept in each iteration, the best on top, and whom each was trained from; a dashed line: the same model. */
export function lineageChart(generations: KeptDoc[][], camp: string): Element {
  const rows = Math.max(1, ...generations.map((one) => one.length));
  const [width, height] = [generations.length * COLUMN + 8, rows * ROW + 26];
  const place = (k: number, n: number): [number, number] => [k * COLUMN + COLUMN / 2 + 4, n * ROW + ROW / 2];
  const parts: Element[] = [];
  for (const [k, kept] of generations.entries()) {
    const before = generations[k - 1] ?? [];
    for (const [n, one] of kept.entries()) {
      const from = before.findIndex((other) => other.name === one.parent);
      if (from < 0) continue;
      const [[x1, y1], [x2, y2]] = [place(k - 1, from), place(k, n)];
      parts.push(draw("line", { x1, y1, x2, y2, class: one.parent === one.name ? "same" : "child" }));
    }
  }
  for (const [k, kept] of generations.entries()) {
    parts.push(draw("text", { x: place(k, 0)[0], y: height - 6, "text-anchor": "middle" }, `iteration ${k}`));
    for (const [n, one] of kept.entries()) parts.push(plateOf(one, place(k, n)));
  }
  return draw("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `Kept ${camp === "both" ? "" : camp} models by iteration, and whom each was trained from` }, ...parts);
}

function plateOf(one: KeptDoc, [x, y]: [number, number]): Element {
  const name = one.name.length > 14 ? `${one.name.slice(0, 13)}…` : one.name;
  const box = draw("rect", { x: x - COLUMN / 2 + 6, y: y - 17, width: COLUMN - 12, height: 34, rx: 6, class: "plate" });
  const words = draw("text", { x, y: y - 3, "text-anchor": "middle", class: "model" }, name);
  const rate = draw("text", { x, y: y + 11, "text-anchor": "middle" }, `${Math.round(100 * one.rate)} % won`);
  return draw("g", {}, box, words, rate, draw("title", {}, `${one.name}${one.parent && one.parent !== one.name ? `, trained from ${one.parent}` : ""}`));
}
