// The panel of the log: a line a shot, and the luck of both camps.

import { byId, make, say } from "./dom";
import { type Entry, type Group, type LuckCurve, signed } from "./log";
import type { Scene } from "./scene";
import { CAMPS, type Camp } from "./story";
import { drawLuck, mark, markName } from "./timeline";

const GROUPS: [Group, string][] = [["fire", "Fire"], ["sight", "First sights"], ["orders", "Orders"], ["rest", "More"]];
const shownGroups = new Set<Group>(["fire", "sight"]);
const MOST_ROWS = 600;

export function logPanel(panel: HTMLElement, scene: Scene, follow: boolean): void {
  const key = `log ${scene.game.view} ${scene.palette.dark} ${[...shownGroups].join()} ${scene.entries.length}`; // a game that is played has more of them
  if (panel.dataset.key !== key) {
    panel.dataset.key = key;
    buildLog(panel, scene);
  }
  const tick = scene.state.tick;
  const canvas = panel.querySelector<HTMLCanvasElement>("#luck");
  if (canvas) {
    drawLuck(canvas, scene.luck, scene.time, scene.game.last, scene.palette, scene.ratio);
    say(byId("lucky"), CAMPS.map((camp) => luckText(camp, scene.luck[camp], tick)).join(" "));
  }
  const now = markRows(tick);
  if (now && follow && !panel.contains(document.activeElement)) keepInView(panel, now);
}

let rows: { at: number; row: HTMLElement }[] = []; // of the log that is shown
let past = 0; // how many of them have happened

/** Grey what is still to come, and mark the last row that has happened; gives that row where it is another one than before. */
function markRows(tick: number): HTMLElement | null {
  const before = past;
  while (past < rows.length && rows[past].at <= tick) past += 1;
  while (past > 0 && rows[past - 1].at > tick) past -= 1;
  for (const { row } of rows.slice(before, past)) row.classList.remove("later");
  for (const { row } of rows.slice(past, before)) row.classList.add("later");
  if (past === before) return null;
  rows[before - 1]?.row.classList.remove("now");
  const now = rows[past - 1]?.row ?? null;
  now?.classList.add("now");
  return now;
}

function keepInView(panel: HTMLElement, row: HTMLElement): void {
  const [top, height] = [row.offsetTop - panel.offsetTop, panel.clientHeight];
  if (top < panel.scrollTop + 40 || top > panel.scrollTop + height - 80) panel.scrollTop = top - height * 0.6;
}

function buildLog(panel: HTMLElement, scene: Scene): void {
  const chips = make("div", { id: "chips", role: "group", "aria-label": "What the log shows" });
  for (const [group, name] of GROUPS) {
    const chip = make("button", { type: "button", "aria-pressed": String(shownGroups.has(group)) }, name);
    chip.addEventListener("click", () => {
      if (!shownGroups.delete(group)) shownGroups.add(group);
      panel.dataset.key = "";
      logPanel(panel, scene, true);
    });
    chips.append(chip);
  }
  const list = make("ul", { id: "rows" });
  for (const one of scene.entries.filter((entry) => shownGroups.has(entry.group) && entry.shape !== "choice").slice(0, MOST_ROWS)) list.append(logRow(scene, one));
  rows = [...list.querySelectorAll<HTMLElement>("button")].map((row) => ({ at: Number(row.dataset.tick), row }));
  past = 0;
  const luck = scene.game.view === "referee" ? [make("canvas", { id: "luck", role: "img", "aria-label": "Luck of both camps over time" }), make("p", { id: "lucky", class: "small soft" })] : [];
  panel.replaceChildren(chips, ...luck, list);
}

function luckText(camp: Camp, curve: LuckCurve | undefined, tick: number): string {
  if (!curve) return "";
  const k = curve.ticks.filter((one) => one <= tick).length - 1;
  const [sum, sigma] = [curve.sum[k], curve.sigma[k]];
  const word = Math.abs(sum) <= sigma ? "within one sigma" : sum > 0 ? "lucky" : "unlucky";
  return `Luck of ${camp}'s shots: ${signed(sum, 1)} points, sigma ${sigma.toFixed(1)}: ${word}.`;
}

function logRow(scene: Scene, one: Entry): HTMLElement {
  const icon = make("canvas", { width: String(16 * scene.ratio), height: String(16 * scene.ratio), role: "img", "aria-label": markName(one.shape) });
  const ctx = icon.getContext("2d");
  ctx?.setTransform(scene.ratio, 0, 0, scene.ratio, 0, 0);
  if (ctx) mark(ctx, one, { x: 8, y: 8 }, scene.palette);
  const words = one.text.split(" ");
  const actor = /^(red|blue) (sees|loses|takes)/.test(one.text) ? 1 : 2;
  const text = make("span", {}, make("b", { class: `t-${one.camp}` }, words.slice(0, actor).join(" ")), ` ${words.slice(actor).join(" ")}`);
  if (one.luck !== null) text.append(make("span", { class: "luck" }, ` [${signed(one.luck, 1)}]`));
  const row = make("button", { type: "button", class: "later", "data-tick": String(one.tick) }, make("span", { class: "tick" }, String(one.tick)), icon, text);
  row.addEventListener("click", () => scene.seek(one.tick));
  row.addEventListener("pointerenter", () => scene.point(one));
  row.addEventListener("pointerleave", () => scene.point(null));
  return make("li", {}, row);
}
