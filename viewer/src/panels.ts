// The panel beside the map: the pieces with the card of what is picked, the log, and the policy.

import { CONCEALED, PASSABLE, PAVED, SLUSHY, apart, cellName, parseCell } from "./hex";
import { badge, bars, byId, facts, make, say } from "./dom";
import { type Entry, type Group, type LuckCurve, signed, spoken } from "./log";
import type { Palette } from "./palette";
import type { Sight } from "./los";
import type { Game, Piece, Shown, State } from "./state";
import { CAMPS, type Camp, type Choice, valueAt } from "./story";
import { drawLuck, mark, markName } from "./timeline";

export interface Scene {
  game: Game;
  state: State;
  time: number;
  picked: Piece | null;
  cell: number; // picked; -1 none
  hover: number; // cell under the pointer; -1 none
  entries: Entry[];
  luck: Partial<Record<Camp, LuckCurve>>;
  palette: Palette;
  ratio: number;
  sight: Sight;
  pick(piece: Piece): void;
  seek(tick: number): void;
  point(entry: Entry | null): void;
}

export type Tab = "pieces" | "log" | "policy";
const TIMERS: [string, string][] = [
  ["suppressed", "suppressed"], ["cool", "cools down"], ["mortar_cool", "mortar cools"], ["stop", "stops"],
  ["hide", "hides"], ["board", "boards"], ["decompress", "recovers"],
];

// --- pieces ---------------------------------------------------------------------------------------

export function piecesPanel(panel: HTMLElement, scene: Scene): void {
  const { game, state } = scene;
  const built = `pieces ${game.view}`;
  if (panel.dataset.key !== built) {
    panel.dataset.key = built;
    panel.replaceChildren(make("div", { id: "card" }), pieceTable(scene));
  }
  const card = byId("card");
  const key = scene.picked || scene.cell >= 0 ? `${state.tick} ${scene.picked?.index} ${scene.cell} ${scene.hover}` : "";
  if (card.dataset.key !== key) {
    card.dataset.key = key;
    card.replaceChildren(scene.picked ? pieceCard(scene, scene.picked) : scene.cell >= 0 ? cellCard(scene, scene.cell) : hint());
  }
  say(byId("caption"), `Pieces at tick ${state.tick}, ${game.view === "referee" ? "as they are" : `as ${game.view} knows them`}`);
  for (const shown of state.pieces) updateRow(byId(`row-${shown.piece.index}`), scene, shown);
  const canvas = panel.querySelector<HTMLCanvasElement>("#profile");
  if (canvas) drawProfile(canvas, scene);
}

function hint(): HTMLElement {
  return make("p", { class: "soft" }, "Pick a piece or a cell on the map. Drag to move, scroll to zoom, ? for the keys.");
}

function pieceTable(scene: Scene): HTMLElement {
  const head = make("tr", {}, ...["piece", "cell", "blood", "does"].map((name) => make("th", { scope: "col" }, name)));
  const rows = scene.game.pieces.map((piece) => pieceRow(scene, piece));
  return make("table", {}, make("caption", { id: "caption", class: "soft small" }), make("thead", {}, head), make("tbody", {}, ...rows));
}

function pieceRow(scene: Scene, piece: Piece): HTMLElement {
  const button = make("button", { class: "link", type: "button" }, badge(piece.camp, piece.letter), make("span", {}, make("span", { class: "unseen" }, `${piece.camp} `), piece.short));
  button.addEventListener("click", () => scene.pick(piece));
  return make("tr", { id: `row-${piece.index}` }, make("td", {}, button), make("td"), make("td"), make("td"));
}

function updateRow(row: HTMLElement, scene: Scene, shown: Shown): void {
  const { game, state } = scene;
  const [, where, blood, does] = row.children as unknown as HTMLElement[];
  const name = [shown.blood === 0 ? "gone" : "", scene.picked === shown.piece ? "picked" : ""].join(" ").trim();
  if (row.className !== name) row.className = name;
  say(where, shown.cell < 0 ? "?" : cellName(game.map, shown.cell));
  say(does, saidOf(game, shown, state.tick, false));
  const left = shown.how === "never" ? "?" : String(shown.blood);
  if (blood.dataset.left === left) return;
  blood.dataset.left = left;
  blood.replaceChildren(shown.how === "never" ? "?" : bars(shown.blood, game.story.rules.kinds[shown.piece.kind].blood));
}

function saidOf(game: Game, shown: Shown, tick: number, withGoal: boolean): string {
  if (shown.how === "never") return "never seen";
  if (shown.blood === 0) return "destroyed";
  if (shown.how === "lost") return `seen ${shown.age} ticks ago`;
  const doing = shown.how === "own" ? game.doing(shown.piece, tick) : shown.moving ? "moving" : "stands";
  const path = game.path(shown.piece, tick);
  const goal = withGoal && doing === "moving" && path.length ? ` to ${cellName(game.map, path[path.length - 1])}` : "";
  const states = [shown.hidden ? "hidden" : "", shown.suppressed ? "suppressed" : ""].filter((word) => word && word !== doing);
  return [doing + goal, ...states].join(", ");
}

function pieceCard(scene: Scene, piece: Piece): HTMLElement {
  const { game, state } = scene;
  const shown = state.pieces[piece.index];
  const kind = game.story.rules.kinds[piece.kind];
  const rows: [string, string | HTMLElement | null][] = [
    ["where", shown.cell < 0 ? "not known" : place(scene, shown)],
    ["does", saidOf(game, shown, state.tick, true)],
    ["blood", shown.how === "never" ? "" : `${shown.blood} of ${kind.blood}, ${kind.value} points each`],
  ];
  if (piece.own && shown.blood > 0) rows.push(...ownRows(scene, piece));
  if (shown.blood > 0 && shown.how !== "never") {
    const seers = game.seenBy(piece, state.tick).map((one) => spoken(one.name));
    if (shown.how === "own" || seers.length) rows.push(["seen by", game.view === "referee" || piece.camp !== game.view ? seers.join(", ") || "nobody" : ""]);
  }
  if (game.view === "referee") rows.push(["believed", believed(scene, piece)]);
  const box = make("section", {}, make("h2", {}, badge(piece.camp, piece.letter), spoken(piece.name)), facts(rows));
  if (scene.hover >= 0 && shown.cell >= 0 && shown.blood > 0) box.append(...profile(scene, shown));
  return box;
}

function place(scene: Scene, shown: Shown): string {
  const { map } = scene.game;
  const words = ground(map.bits[shown.cell]);
  const aboard = shown.carrier >= 0 ? `aboard ${scene.game.pieces[shown.carrier].short}, ` : "";
  return `${aboard}${cellName(map, shown.cell)}, ${map.level[shown.cell] * map.gradeM} m, ${words}`;
}

export function ground(bits: number): string {
  const words = [bits & PASSABLE ? "" : "closed", bits & PAVED ? "road" : "", bits & SLUSHY ? "soft" : ""];
  words.push(bits & CONCEALED ? (bits & PAVED ? "built-up" : "forest") : "");
  return words.filter(Boolean).join(", ") || "open";
}

function ownRows(scene: Scene, piece: Piece): [string, string][] {
  const { game, state } = scene;
  const { tick } = state;
  const own = piece.own;
  if (!own) return [];
  const path = game.path(piece, tick);
  const left = TIMERS.map(([name, word]) => [word, valueAt(own[`${name}_ends`], tick, 0) - tick] as const).filter(([, ticks]) => ticks > 0);
  const ammo = valueAt(own.ammo, tick, []);
  const rounds = game.story.rules.kinds[piece.kind].weapons.map(([name], k) => `${name} ${ammo[k] ?? 0}`);
  const sees = valueAt(own.sees, tick, []).map((index) => spoken(game.pieces[index].name));
  const rider = state.pieces.find((one) => one.carrier === piece.index && one.blood > 0);
  return [
    ["carries", rider ? rider.piece.short : ""],
    ["path", path.length ? `${path.length} ${path.length === 1 ? "cell" : "cells"} to ${cellName(game.map, path[path.length - 1])}` : ""],
    ["timers", left.map(([word, ticks]) => `${word} ${ticks}`).join(", ")],
    ["rounds", rounds.join(", ")],
    ["sees", sees.join(", ") || "no enemy"],
  ];
}

function believed(scene: Scene, piece: Piece): string {
  const { game, state } = scene;
  const belief = game.believed(piece, state.tick);
  if (belief.how === "never") return "never seen by the enemy";
  if (belief.how === "seen") return "seen by the enemy now";
  const truth = state.pieces[piece.index];
  const wrong = truth.cell >= 0 && truth.blood > 0 ? `, ${apart(game.map, belief.cell, truth.cell)} cells off` : "";
  return `in ${cellName(game.map, belief.cell)}, ${belief.age} ticks ago${wrong}`;
}

function cellCard(scene: Scene, cell: number): HTMLElement {
  const { game, state } = scene;
  const { map } = game;
  const here = state.pieces.filter((one) => one.cell === cell && one.blood > 0 && one.how !== "lost");
  const point = game.story.points.findIndex(([, where]) => where === cell);
  const rows: [string, string][] = [
    ["height", `${map.level[cell] * map.gradeM} m, level ${map.level[cell]}`],
    ["ground", ground(map.bits[cell])],
    ["point", point < 0 ? "" : `${game.story.points[point][0]}, ${game.story.points[point][2]} points, ${state.owners[point]}`],
    ["here", here.map((one) => spoken(one.piece.name)).join(", ") || "nobody"],
    ["in sight of", observers(scene, cell)],
  ];
  const box = make("section", {}, make("h2", {}, `Cell ${cellName(map, cell)}`), facts(rows));
  if (scene.hover >= 0 && scene.hover !== cell) box.append(...profile(scene, null));
  return box;
}

function observers(scene: Scene, cell: number): string {
  const { game, state } = scene;
  const kinds = game.story.rules.kinds;
  const eyes = state.pieces.filter((one) => one.how === "own" && one.blood > 0 && one.carrier < 0);
  const seers = eyes.filter((one) => {
    const reach = kinds[one.piece.kind].sight.tank;
    return apart(game.map, one.cell, cell) <= reach && scene.sight.clear(one.cell, cell, one.piece.kind === "aerocraft", false);
  });
  return seers.map((one) => spoken(one.piece.name)).join(", ") || "nobody";
}

// --- the ground between two cells -----------------------------------------------------------------

function ends(scene: Scene): { from: number; to: number; flies: boolean } {
  const shown = scene.picked ? scene.state.pieces[scene.picked.index] : null;
  return { from: shown ? shown.cell : scene.cell, to: scene.hover, flies: shown?.piece.kind === "aerocraft" };
}

function profile(scene: Scene, shown: Shown | null): HTMLElement[] {
  const { from, to, flies } = ends(scene);
  if (from < 0 || to < 0 || from === to) return [];
  const cells = apart(scene.game.map, from, to);
  const clear = scene.sight.clear(from, to, flies, false);
  const text = `${cellName(scene.game.map, to)}: ${cells} ${cells === 1 ? "cell" : "cells"} away, ${clear ? "in line of sight" : "no line of sight"}`;
  return [make("h3", {}, shown ? "To the cell under the pointer" : "Between the two cells"), make("p", { class: "small" }, text), make("canvas", { id: "profile", "aria-hidden": "true" })];
}

function drawProfile(canvas: HTMLCanvasElement, scene: Scene): void {
  const { map } = scene.game;
  const { from, to, flies } = ends(scene);
  const steps = apart(map, from, to);
  const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, scene.ratio];
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const ctx = canvas.getContext("2d");
  if (!ctx || steps === 0) return;
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  const line = scene.sight.cells(from, to);
  const eye = flies ? scene.game.story.rules.air_height_m : 0;
  const heights = line.map((cell) => (cell < 0 ? 0 : map.level[cell] * map.gradeM));
  const tops = line.map((cell, k) => heights[k] + (cell >= 0 && map.bits[cell] & CONCEALED ? map.gradeM : 0));
  const most = Math.max(...tops, heights[0] + eye, 20) * 1.15;
  const low = Math.min(...heights) * 0.8;
  const x = (k: number) => 6 + (k / steps) * (width - 12);
  const y = (m: number) => height - 6 - ((m - low) / (most - low)) * (height - 16);
  const area = (values: number[], colour: string) => {
    ctx.beginPath();
    ctx.moveTo(x(0), height);
    values.forEach((value, k) => ctx.lineTo(x(k), y(value)));
    ctx.lineTo(x(steps), height);
    ctx.closePath();
    ctx.fillStyle = colour;
    ctx.fill();
  };
  area(tops, scene.palette.tree);
  area(heights, scene.palette.ground[4]);
  ctx.beginPath();
  ctx.moveTo(x(0), y(heights[0] + eye));
  ctx.lineTo(x(steps), y(heights[steps]));
  ctx.lineWidth = 1.6;
  ctx.setLineDash(scene.sight.clear(from, to, flies, false) ? [] : [4, 4]);
  ctx.strokeStyle = scene.palette.ink;
  ctx.stroke();
}

// --- log ------------------------------------------------------------------------------------------

const GROUPS: [Group, string][] = [["fire", "Fire"], ["sight", "First sights"], ["orders", "Orders"], ["rest", "More"]];
const shownGroups = new Set<Group>(["fire", "sight"]);
const MOST_ROWS = 600;

export function logPanel(panel: HTMLElement, scene: Scene, follow: boolean): void {
  const key = `log ${scene.game.view} ${scene.palette.dark} ${[...shownGroups].join()}`;
  if (panel.dataset.key !== key) {
    panel.dataset.key = key;
    buildLog(panel, scene);
  }
  const tick = scene.state.tick;
  let now: HTMLElement | null = null;
  for (const row of panel.querySelectorAll<HTMLElement>("#rows button")) {
    const at = Number(row.dataset.tick);
    row.classList.toggle("later", at > tick);
    row.classList.remove("now");
    if (at <= tick) now = row;
  }
  now?.classList.add("now");
  if (now && follow && !panel.contains(document.activeElement)) keepInView(panel, now);
  const canvas = panel.querySelector<HTMLCanvasElement>("#luck");
  if (canvas) {
    drawLuck(canvas, scene.luck, scene.time, scene.game.last, scene.palette, scene.ratio);
    say(byId("lucky"), CAMPS.map((camp) => luckText(camp, scene.luck[camp], tick)).join(" "));
  }
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
  const rows = make("ul", { id: "rows" });
  for (const one of scene.entries.filter((entry) => shownGroups.has(entry.group) && entry.shape !== "choice").slice(0, MOST_ROWS)) rows.append(logRow(scene, one));
  const luck = scene.game.view === "referee" ? [make("canvas", { id: "luck", role: "img", "aria-label": "Luck of both camps over time" }), make("p", { id: "lucky", class: "small soft" })] : [];
  panel.replaceChildren(chips, ...luck, rows);
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
  const row = make("button", { type: "button", "data-tick": String(one.tick) }, make("span", { class: "tick" }, String(one.tick)), icon, text);
  row.addEventListener("click", () => scene.seek(one.tick));
  row.addEventListener("pointerenter", () => scene.point(one));
  row.addEventListener("pointerleave", () => scene.point(null));
  return make("li", {}, row);
}

// --- policy ---------------------------------------------------------------------------------------

export interface Decision {
  tick: number;
  choice: Choice;
  tasks: string[];
}

/** What a piece decided last. */
export function decisionOf(game: Game, piece: Piece, tick: number): Decision | null {
  const policy = game.story.policy[piece.camp];
  const made = policy?.decisions.filter(([at]) => at <= tick) ?? [];
  for (let k = made.length - 1; policy && k >= 0; k--) {
    const choice = made[k][1].find(([index]) => index === piece.index);
    if (choice) return { tick: made[k][0], choice, tasks: policy.tasks };
  }
  return null;
}

/** Ticks at which a piece chose another task than before. */
export function mindsOf(game: Game, piece: Piece | null): number[] {
  const policy = piece ? game.story.policy[piece.camp] : undefined;
  const found: number[] = [];
  let before = -1;
  for (const [tick, choices] of policy?.decisions ?? []) {
    const choice = choices.find(([index]) => index === piece?.index);
    const task = choice ? choice[2][choice[1]] : before;
    if (before >= 0 && task !== before) found.push(tick);
    before = task;
  }
  return found;
}

/** The cell that a task's text names, -1 where it names none. */
export function taskCell(game: Game, text: string): number {
  const name = text.split(" ").find((word) => /^[0-9]{4}$/.test(word));
  if (name) return parseCell(game.map, name);
  const target = text.split(" ").find((word) => word.includes(":"));
  const piece = target ? game.byName(target) : undefined;
  return piece ? -2 - piece.index : -1;
}

export function policyPanel(panel: HTMLElement, scene: Scene): void {
  const decision = scene.picked ? decisionOf(scene.game, scene.picked, scene.state.tick) : null;
  const key = `policy ${scene.game.view} ${scene.picked?.index} ${decision?.tick}`;
  if (panel.dataset.key === key) return;
  panel.dataset.key = key;
  const known = CAMPS.filter((camp) => scene.game.story.policy[camp]);
  if (known.length === 0) {
    panel.replaceChildren(make("p", { class: "soft" }, "This replay has no policy layer: it was recorded without what its players thought."));
  } else if (!scene.picked || !decision) {
    panel.replaceChildren(make("p", { class: "soft" }, `Pick a piece of ${known.join(" or ")} to see its tasks and their values.`));
  } else {
    panel.replaceChildren(...taskList(scene.picked, decision), ...reward(scene, scene.picked));
  }
}

function taskList(piece: Piece, decision: Decision): HTMLElement[] {
  const [, chosen, tasks, q, way] = decision.choice;
  const base = q[chosen] ?? 0;
  const most = Math.max(1, ...q.map((value) => Math.abs(value - base)));
  const order = tasks.map((_, k) => k).sort((a, b) => (q[b] ?? 0) - (q[a] ?? 0));
  const list = make("ol", { class: "tasks" });
  for (const k of order) {
    const bar = make("span", { class: "bar", "aria-hidden": "true" });
    if (q.length) bar.append(piecePart((q[k] - base) / most));
    const value = q.length ? (q[k] / 1000).toFixed(3).replace("-", "−") : "";
    list.append(make("li", { class: k === chosen ? "chosen" : "" }, make("span", {}, decision.tasks[tasks[k]]), bar, make("span", { class: "q" }, value)));
  }
  const second = order.find((k) => k !== chosen);
  const gap = q.length && second !== undefined ? `${((base - q[second]) / 1000).toFixed(3)} before the next` : "";
  const head = make("h2", {}, badge(piece.camp, piece.letter), `${spoken(piece.name)} at tick ${decision.tick}`);
  const rows = facts([["chose", decision.tasks[tasks[chosen]] ?? ""], ["gap", gap], ["led", way ? `the lower level went ${way}` : ""]]);
  const note = q.length
    ? "Q is what it expected of the team by the paper's mixer, not of the piece, in its learner's units: by default 1 is 50 points. Bars are around the chosen task."
    : "A scripted player has no values; this is its plan as a task.";
  return [head, rows, list, make("p", { class: "small soft" }, note)];
}

function piecePart(share: number): HTMLElement {
  const part = make("i");
  part.style.left = `${share < 0 ? 50 + share * 50 : 50}%`;
  part.style.width = `${Math.max(1.5, Math.abs(share) * 50)}%`;
  return part;
}

function reward(scene: Scene, piece: Piece): HTMLElement[] {
  const rows = scene.game.story.rewards?.filter(([tick, camp]) => camp === piece.camp && tick <= scene.state.tick) ?? [];
  const last = rows[rows.length - 1];
  if (!last) return [];
  const parts = Object.entries(last[2]).map(([term, value]): [string, string] => [term, signed(value)]);
  return [make("h3", {}, `Reward since its last decision, tick ${last[0]}`), facts(parts)];
}
