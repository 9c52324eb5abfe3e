// The panel of the pieces: a table that follows the clock, and the card of what is picked.

import { CONCEALED, type HexMap, PASSABLE, PAVED, SLUSHY, apart, cellName } from "./hex";
import { badge, bars, byId, facts, make, say } from "./dom";
import { spoken } from "./log";
import type { Scene } from "./scene";
import type { Game, Piece, Shown } from "./state";
import { valueAt } from "./story";

const TIMERS: [string, string][] = [
  ["suppressed", "suppressed"], ["cool", "cools down"], ["mortar_cool", "mortar cools"], ["stop", "stops"],
  ["hide", "hides"], ["board", "boards"], ["decompress", "recovers"],
];

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

export function pieceCard(scene: Scene, piece: Piece): HTMLElement {
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

/** "0912  120 m  road": a cell in a few words. */
export function cellText(map: HexMap, cell: number): string {
  return `${cellName(map, cell)}  ${map.level[cell] * map.gradeM} m  ${ground(map.bits[cell])}`;
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
