// The layer between fog and pieces: control points, what was asked for (ranges, lines of sight, paths), fire, and beliefs.

import type { Camera } from "./camera";
import { type HexMap, type Point, ROW, STEPS, centre, cubeOf } from "./hex";
import type { Labels } from "./labels";
import type { Entry } from "./log";
import { BURST, fade, type Palette } from "./palette";
import type { Game, Shown, State } from "./state";
import { CAMPS, type Camp } from "./story";
import { type Token, plate } from "./tokens";
import { PATH_CELLS, trace } from "./terrain";

type Ctx = CanvasRenderingContext2D;

export function drawPoints(ctx: Ctx, game: Game, state: State, camera: Camera, palette: Palette, tokens: Token[], labels: Labels): void {
  const size = Math.min(20, Math.max(9, camera.scale * 0.55));
  for (const [k, [name, cell, value]] of game.story.points.entries()) {
    const at = camera.toScreen(centre(game.map, cell));
    const owner = state.owners[k] as Camp | "green";
    diamond(ctx, at, size + 2.5, "#ffffff");
    diamond(ctx, at, size, palette.camp[owner]);
    diamond(ctx, at, size * 0.45, "#ffffff");
    labels.add(ctx, `${name} ${value}`, at, size, tokens, camera);
  }
}

function diamond(ctx: Ctx, at: Point, size: number, colour: string): void {
  ctx.beginPath();
  ctx.moveTo(at.x, at.y - size);
  ctx.lineTo(at.x + size, at.y);
  ctx.lineTo(at.x, at.y + size);
  ctx.lineTo(at.x - size, at.y);
  ctx.closePath();
  ctx.fillStyle = colour;
  ctx.fill();
}

/** The edge of all cells within a distance, clipped by nothing: six corners. */
export function hexagon(ctx: Ctx, map: HexMap, cell: number, reach: number, camera: Camera): void {
  const [q, r] = cubeOf(map, cell);
  const size = reach + 0.55;
  ctx.beginPath();
  for (let k = 0; k <= 6; k++) {
    const [dq, dr] = STEPS[k % 6];
    const at = camera.toScreen(placeOf(q + dq * size, r + dr * size));
    if (k === 0) ctx.moveTo(at.x, at.y);
    else ctx.lineTo(at.x, at.y);
  }
}

function placeOf(q: number, r: number): Point {
  return { x: q + r / 2 + 0.5, y: (r + 2 / 3) * ROW };
}

export function drawRanges(ctx: Ctx, game: Game, shown: Shown, camera: Camera, palette: Palette): void {
  const kind = game.story.rules.kinds[shown.piece.kind];
  const colour = palette.camp[shown.piece.camp];
  const rings: [string, number, number[]][] = [["sees vehicles", kind.sight.tank, [2, 5]], ["sees soldiers", kind.sight.soldier, [2, 3]]];
  for (const [weapon, vehicles, soldiers] of kind.weapons) rings.push([weapon, Math.max(vehicles, soldiers), []]);
  const used = new Map<number, string>();
  for (const [name, reach, dash] of rings) {
    if (reach === 0) continue;
    const label = used.get(reach);
    used.set(reach, label ? `${label}, ${name}` : name);
    if (label) continue;
    hexagon(ctx, game.map, shown.cell, reach, camera);
    ctx.setLineDash(dash);
    ctx.lineWidth = dash.length ? 1.4 : 1.8;
    ctx.strokeStyle = dash.length ? palette.ink : colour;
    ctx.stroke();
  }
  ctx.setLineDash([]);
  for (const [reach, label] of used) {
    const at = camera.toScreen(centre(game.map, shown.cell));
    plate(ctx, `${label} ${reach}`, { x: at.x, y: at.y - (reach + 0.5) * ROW * camera.scale }, 10, palette, 500);
  }
}

/** What is drawn of a field of sight, made once: short paths, because one of all cells takes ten times as long. */
export interface SightPaths {
  open: Path2D[];
  shut: Path2D[];
  hatch: Path2D[];
}

export function sightPaths(map: HexMap, field: Map<number, boolean>): SightPaths {
  const cells = [...field.keys()];
  const open = cells.filter((cell) => field.get(cell));
  const shut = cells.filter((cell) => !field.get(cell));
  const outline = (path: Path2D, place: Point) => trace(path, place, 1.01);
  return { open: paths(map, open, outline), shut: paths(map, shut, outline), hatch: paths(map, shut, stripe) };
}

export function paths(map: HexMap, cells: number[], add: (path: Path2D, place: Point) => void): Path2D[] {
  const found: Path2D[] = [];
  cells.forEach((cell, k) => {
    if (k % PATH_CELLS === 0) found.push(new Path2D());
    add(found[found.length - 1], centre(map, cell));
  });
  return found;
}

export function stripe(path: Path2D, { x, y }: Point): void {
  path.moveTo(x - 0.36, y - 0.36);
  path.lineTo(x + 0.36, y + 0.36);
}

/** Cells in sight are clear, blocked ones hatched. */
export function drawSight(ctx: Ctx, { open, shut, hatch }: SightPaths, camera: Camera, palette: Palette): void {
  withMap(ctx, camera, () => {
    ctx.fillStyle = palette.dark ? "rgba(255,240,170,0.20)" : "rgba(255,236,120,0.36)";
    for (const path of open) ctx.fill(path);
    ctx.fillStyle = "rgba(20,25,35,0.30)";
    for (const path of shut) ctx.fill(path);
    ctx.lineWidth = 0.1;
    ctx.strokeStyle = palette.dark ? "rgba(255,255,255,0.20)" : "rgba(20,25,35,0.34)";
    for (const path of hatch) ctx.stroke(path);
  });
}

export function withMap(ctx: Ctx, camera: Camera, draw: () => void): void {
  const s = camera.scale;
  ctx.save();
  ctx.transform(s, 0, 0, s, camera.width / 2 - camera.x * s, camera.height / 2 - camera.y * s);
  draw();
  ctx.restore();
}

export function drawCell(ctx: Ctx, map: HexMap, cell: number, camera: Camera, palette: Palette): void {
  withMap(ctx, camera, () => {
    ctx.beginPath();
    trace(ctx, centre(map, cell));
    ctx.lineWidth = 2 / camera.scale;
    ctx.strokeStyle = palette.ink;
    ctx.stroke();
  });
}

export function drawPath(ctx: Ctx, map: HexMap, from: Point, cells: number[], camera: Camera, colour: string): void {
  if (cells.length === 0) return;
  const places = [from, ...cells.map((cell) => centre(map, cell))].map((place) => camera.toScreen(place));
  for (const [width, style] of [[5, "rgba(255,255,255,0.75)"], [2.4, colour]] as const) {
    ctx.beginPath();
    places.forEach((place, k) => (k ? ctx.lineTo(place.x, place.y) : ctx.moveTo(place.x, place.y)));
    ctx.lineWidth = width;
    ctx.lineJoin = "round";
    ctx.lineCap = "round";
    ctx.strokeStyle = style;
    ctx.setLineDash(width < 4 ? [6, 5] : []);
    ctx.stroke();
  }
  ctx.setLineDash([]);
  const end = places[places.length - 1];
  ctx.beginPath();
  ctx.arc(end.x, end.y, 4, 0, 7);
  ctx.fillStyle = colour;
  ctx.fill();
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = "#ffffff";
  ctx.stroke();
}

export function arrow(ctx: Ctx, a: Point, b: Point, colour: string, width: number): void {
  const angle = Math.atan2(b.y - a.y, b.x - a.x);
  const head = 4 + width * 2.2;
  ctx.beginPath();
  ctx.moveTo(a.x, a.y);
  ctx.lineTo(b.x - Math.cos(angle) * head * 0.8, b.y - Math.sin(angle) * head * 0.8);
  ctx.lineWidth = width;
  ctx.strokeStyle = colour;
  ctx.lineCap = "round";
  ctx.stroke();
  ctx.beginPath();
  ctx.moveTo(b.x, b.y);
  for (const side of [-0.42, 0.42]) ctx.lineTo(b.x - Math.cos(angle + side) * head, b.y - Math.sin(angle + side) * head);
  ctx.closePath();
  ctx.fillStyle = colour;
  ctx.fill();
}

/** Fire of the last ticks, fading: a line from cell to cell, and what came of it. */
export function drawFire(ctx: Ctx, map: HexMap, entries: Entry[], time: number, lasts: number, camera: Camera, palette: Palette): void {
  for (const one of entries) {
    const left = 1 - (time - one.tick) / lasts;
    if (left <= 0 || left > 1.0001 || one.to < 0 || one.group !== "fire") continue;
    const to = camera.toScreen(centre(map, one.to));
    if (one.shape === "point") ring(ctx, to, (1 - left) * 34 + 12, fade(palette.camp[one.camp], left), 3);
    if (one.from >= 0 && one.from !== one.to && one.shape !== "round") {
      const from = camera.toScreen(centre(map, one.from));
      const hit = one.result > 0 || one.dead;
      ctx.setLineDash(hit ? [] : [4, 4]);
      arrow(ctx, from, to, fade("#ffffff", 0.8 * left), hit ? 5 : 3.4);
      arrow(ctx, from, to, fade(palette.camp[one.camp], left), hit ? 3 : 1.6);
      ctx.setLineDash([]);
    }
    if (one.result > 0 || one.dead || one.shape === "hit") burst(ctx, to, one.dead ? 20 : 14, left);
  }
}

function burst(ctx: Ctx, at: Point, size: number, left: number): void {
  ctx.beginPath();
  for (let k = 0; k < 16; k++) {
    const reach = k % 2 ? size * 0.5 : size;
    const angle = (Math.PI / 8) * k;
    ctx.lineTo(at.x + Math.cos(angle) * reach, at.y + Math.sin(angle) * reach);
  }
  ctx.closePath();
  ctx.fillStyle = fade(BURST, 0.85 * left);
  ctx.fill();
  ctx.lineWidth = 1.2;
  ctx.strokeStyle = `rgba(120,50,0,${0.8 * left})`;
  ctx.stroke();
}

export function ring(ctx: Ctx, at: Point, size: number, colour: string, width: number): void {
  ctx.beginPath();
  ctx.arc(at.x, at.y, size, 0, 7);
  ctx.lineWidth = width;
  ctx.strokeStyle = colour;
  ctx.stroke();
}

/** Mortar rounds on their way, bursts, and close combats. */
export function drawRounds(ctx: Ctx, game: Game, state: State, time: number, camera: Camera, palette: Palette): void {
  for (const [owner, cell, fired, lands, gone] of game.story.rounds) {
    if (time < fired || time >= (gone ?? lands)) continue;
    const piece = game.pieces[owner];
    const from = camera.toScreen(game.shown(piece, fired).at);
    const to = camera.toScreen(centre(game.map, cell));
    const share = (time - fired) / (lands - fired);
    const height = Math.hypot(to.x - from.x, to.y - from.y) * 0.25;
    const x = from.x + (to.x - from.x) * share;
    const y = from.y + (to.y - from.y) * share - height * 4 * share * (1 - share);
    ring(ctx, to, 9, fade(palette.camp[piece.camp], 0.9), 2);
    ctx.beginPath();
    ctx.arc(x, y, 3.4, 0, 7);
    ctx.fillStyle = palette.ink;
    ctx.fill();
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = "#ffffff";
    ctx.stroke();
  }
  for (const cell of state.bursts) burst(ctx, camera.toScreen(centre(game.map, cell)), 12, 0.75);
  for (const cell of state.fights) ring(ctx, camera.toScreen(centre(game.map, cell)), Math.max(15, camera.scale * 0.7), palette.warn, 3);
}

/** Where a piece that was lost from sight can be by now: as far as it can have hopped. */
export function drawReach(ctx: Ctx, game: Game, ghost: Shown, camera: Camera, palette: Palette, picked: boolean): void {
  const reach = Math.floor(ghost.age / game.story.rules.kinds[ghost.piece.kind].hop_ticks);
  if (reach === 0 || reach > game.map.width) return;
  hexagon(ctx, game.map, ghost.cell, reach, camera);
  const colour = palette.camp[ghost.piece.camp];
  ctx.fillStyle = fade(colour, picked ? 0.12 : 0.05);
  ctx.fill();
  ctx.lineWidth = picked ? 3.6 : 2.6;
  ctx.strokeStyle = "rgba(255,255,255,0.3)";
  ctx.stroke();
  ctx.setLineDash([6, 5]);
  ctx.lineWidth = picked ? 2 : 1.3;
  ctx.strokeStyle = fade(colour, picked ? 1 : 0.8);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** From a piece to an enemy that it sees. */
export function drawEye(ctx: Ctx, a: Point, b: Point, palette: Palette): void {
  ctx.beginPath();
  ctx.moveTo(a.x, a.y);
  ctx.lineTo(b.x, b.y);
  ctx.lineWidth = 1.2;
  ctx.setLineDash([1, 4]);
  ctx.strokeStyle = palette.ink;
  ctx.stroke();
  ctx.setLineDash([]);
}

/** Who sees whom: from each piece to each enemy that it sees, in the colour of its camp; two that see each other have two lines. */
export function drawEyes(ctx: Ctx, eyes: [Camp, Point, Point][], palette: Palette): void {
  for (const camp of CAMPS) {
    ctx.beginPath();
    for (const [, a, b] of eyes.filter(([seer]) => seer === camp)) {
      const apart = Math.hypot(b.x - a.x, b.y - a.y) || 1;
      const [x, y] = [(2 * (b.y - a.y)) / apart, (-2 * (b.x - a.x)) / apart]; // to the left of who looks
      ctx.moveTo(a.x + x, a.y + y);
      ctx.lineTo(b.x + x, b.y + y);
    }
    for (const [width, colour, dash] of [[2.6, "rgba(255,255,255,0.5)", []], [1.5, palette.camp[camp], [1.5, 3.5]]] as [number, string, number[]][]) {
      ctx.lineWidth = width;
      ctx.setLineDash(dash);
      ctx.strokeStyle = colour;
      ctx.stroke();
    }
  }
  ctx.setLineDash([]);
}

/** From where a camp believes a piece to be to where it is. */
export function drawError(ctx: Ctx, ghost: Point, truth: Point, colour: string): void {
  for (const [width, style] of [[3.4, "rgba(255,255,255,0.7)"], [1.6, colour]] as const) {
    ctx.beginPath();
    ctx.moveTo(ghost.x, ghost.y);
    ctx.lineTo(truth.x, truth.y);
    ctx.lineWidth = width;
    ctx.setLineDash([2, 5]);
    ctx.lineCap = "round";
    ctx.strokeStyle = style;
    ctx.stroke();
  }
  ctx.setLineDash([]);
}
