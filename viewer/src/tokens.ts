// Pieces: a square for red, a disc for blue, each with its letter, a white rim, and its blood as bars.

import type { Camera } from "./camera";
import { type HexMap, type Point, centre } from "./hex";
import { fade, type Palette } from "./palette";
import type { Game, Shown, State } from "./state";
import type { Camp } from "./story";

export interface Token {
  shown: Shown;
  home: Point; // where it belongs, on the screen
  at: Point; // where it is drawn: beside others, not over them
  size: number; // half its width
  ghost: boolean; // believed, not seen
  rider: Shown | null;
  heading: number | null; // angle of the hop under way
}

const FLAT = 0.78; // below a token stands its blood: one above another needs more room than one beside another
const DEAD_TICKS = 90; // until a wreck has faded

export function tokenSize(camera: Camera): number {
  return Math.min(24, Math.max(9.5, camera.scale * 0.42));
}

/** The tokens of a state: the living, and ghosts where the view has them. */
export function tokensOf(game: Game, state: State, camera: Camera, ghosts: Shown[], away: Set<Shown>): Token[] {
  const size = tokenSize(camera);
  const found: Token[] = [];
  for (const shown of state.pieces) {
    if (shown.cell < 0 || shown.blood === 0 || shown.carrier >= 0) continue;
    const rider = state.pieces.find((one) => one.carrier === shown.piece.index && one.blood > 0) ?? null;
    found.push({ ...token(shown, camera, size, shown.how === "lost"), rider, heading: headingOf(game.map, shown) });
  }
  for (const shown of ghosts) if (away.has(shown)) found.push(token(shown, camera, size * 0.82, true));
  spread(found);
  return found.filter((one) => near(one.at, camera));
}

function token(shown: Shown, camera: Camera, size: number, ghost: boolean): Token {
  const home = camera.toScreen(shown.at);
  return { shown, home, at: { ...home }, size, ghost, rider: null, heading: null };
}

function headingOf(map: HexMap, shown: Shown): number | null {
  if (shown.next < 0) return null;
  const [here, there] = [centre(map, shown.cell), centre(map, shown.next)];
  return Math.atan2(there.y - here.y, there.x - here.x);
}

function near(place: Point, camera: Camera): boolean {
  return place.x > -40 && place.y > -40 && place.x < camera.width + 40 && place.y < camera.height + 40;
}

/** Push tokens apart until none lies over another; the same places give the same picture. */
function spread(tokens: Token[]): void {
  for (let round = 0; round < 14; round++) {
    let moved = false;
    for (let i = 0; i < tokens.length; i++) {
      for (let j = i + 1; j < tokens.length; j++) moved = part(tokens[i], tokens[j], i, j) || moved;
    }
    if (!moved) return;
  }
}

function part(a: Token, b: Token, i: number, j: number): boolean {
  const wanted = (a.size + b.size) * 1.06 + (a.ghost || b.ghost ? 9 : 2);
  let dx = b.at.x - a.at.x;
  let dy = (b.at.y - a.at.y) * FLAT;
  let apart = Math.hypot(dx, dy);
  if (apart >= wanted) return false;
  if (apart < 0.01) {
    const angle = ((i * 5 + j * 3) % 12) * (Math.PI / 6) + 0.3;
    [dx, dy, apart] = [Math.cos(angle), Math.sin(angle), 1];
  }
  const push = ((wanted - Math.min(apart, wanted)) / 2 + 0.1) / apart;
  a.at.x -= dx * push;
  a.at.y -= (dy * push) / FLAT;
  b.at.x += dx * push;
  b.at.y += (dy * push) / FLAT;
  return true;
}

export function drawTokens(ctx: CanvasRenderingContext2D, tokens: Token[], picked: number, palette: Palette): void {
  for (const one of tokens) leader(ctx, one, palette);
  const order = [...tokens].sort((a, b) => rank(a, picked) - rank(b, picked));
  for (const one of order) drawToken(ctx, one, one.shown.piece.index === picked, palette);
}

function rank(one: Token, picked: number): number {
  return one.shown.piece.index === picked ? 2 : one.ghost ? 0 : 1;
}

/** A thread from a token that was moved aside to its cell. */
function leader(ctx: CanvasRenderingContext2D, one: Token, palette: Palette): void {
  const away = Math.hypot(one.at.x - one.home.x, one.at.y - one.home.y);
  if (away < one.size * 0.9) return;
  ctx.beginPath();
  ctx.moveTo(one.home.x, one.home.y);
  ctx.lineTo(one.at.x, one.at.y);
  ctx.strokeStyle = fade(palette.camp[one.shown.piece.camp], 0.75);
  ctx.lineWidth = 1.5;
  ctx.stroke();
  ctx.beginPath();
  ctx.arc(one.home.x, one.home.y, 2.2, 0, 7);
  ctx.fillStyle = palette.camp[one.shown.piece.camp];
  ctx.fill();
}

export function outline(ctx: CanvasRenderingContext2D, camp: Camp, at: Point, size: number): void {
  ctx.beginPath();
  if (camp === "red") ctx.roundRect(at.x - size * 0.92, at.y - size * 0.92, size * 1.84, size * 1.84, size * 0.28);
  else ctx.arc(at.x, at.y, size, 0, 2 * Math.PI);
}

function drawToken(ctx: CanvasRenderingContext2D, one: Token, picked: boolean, palette: Palette): void {
  const { shown, at, size } = one;
  const colour = palette.camp[shown.piece.camp];
  if (picked) {
    outline(ctx, shown.piece.camp, at, size + 5);
    ctx.strokeStyle = palette.ink;
    ctx.lineWidth = 2.5;
    ctx.stroke();
  }
  if (one.heading !== null) chevron(ctx, at, size, one.heading, colour);
  if (one.ghost) drawGhost(ctx, one, colour);
  else drawSolid(ctx, one, colour);
  letter(ctx, shown.piece.letter, at, size, one.ghost ? colour : palette.rim);
  if (!one.ghost || shown.how === "lost") blood(ctx, one, palette);
  if (one.ghost) age(ctx, one, palette);
  if (shown.suppressed) suppressed(ctx, at, size, palette);
  if (one.rider) rider(ctx, one, colour, palette);
}

/** Where it is going. */
function chevron(ctx: CanvasRenderingContext2D, at: Point, size: number, angle: number, colour: string): void {
  const reach = size * 1.28;
  ctx.beginPath();
  for (const [turn, far] of [[0, reach + size * 0.42], [0.42, reach], [-0.42, reach]]) {
    ctx.lineTo(at.x + Math.cos(angle + turn) * far, at.y + Math.sin(angle + turn) * far);
  }
  ctx.closePath();
  ctx.fillStyle = colour;
  ctx.fill();
  ctx.lineWidth = 1;
  ctx.strokeStyle = "#ffffff";
  ctx.stroke();
}

function drawSolid(ctx: CanvasRenderingContext2D, one: Token, colour: string): void {
  outline(ctx, one.shown.piece.camp, one.at, one.size);
  ctx.fillStyle = colour;
  ctx.fill();
  ctx.lineWidth = Math.max(1.6, one.size * 0.13);
  ctx.strokeStyle = "#ffffff";
  if (one.shown.hidden) ctx.setLineDash([one.size * 0.3, one.size * 0.24]);
  ctx.stroke();
  ctx.setLineDash([]);
  outline(ctx, one.shown.piece.camp, one.at, one.size + ctx.lineWidth / 2 + 0.4);
  ctx.lineWidth = 0.8;
  ctx.strokeStyle = "rgba(10,14,20,0.55)";
  ctx.stroke();
}

function drawGhost(ctx: CanvasRenderingContext2D, one: Token, colour: string): void {
  outline(ctx, one.shown.piece.camp, one.at, one.size);
  ctx.fillStyle = "rgba(255,255,255,0.82)";
  ctx.fill();
  ctx.setLineDash([3.5, 2.5]);
  ctx.lineWidth = 2;
  ctx.strokeStyle = colour;
  ctx.stroke();
  ctx.setLineDash([]);
}

function letter(ctx: CanvasRenderingContext2D, text: string, at: Point, size: number, colour: string): void {
  ctx.font = `700 ${Math.round(size * 1.15)}px system-ui, -apple-system, "Segoe UI", sans-serif`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillStyle = colour;
  ctx.fillText(text, at.x, at.y + size * 0.06);
}

/** One bar for each vehicle or squad; lost ones are hollow. */
function blood(ctx: CanvasRenderingContext2D, one: Token, palette: Palette): void {
  const full = Math.max(one.shown.blood, fullBlood.get(one.shown.piece.kind) ?? 0);
  const width = Math.min(6, (one.size * 2) / full - 1);
  const left = one.at.x - (full * (width + 1) - 1) / 2;
  const top = one.at.y + one.size + 2;
  ctx.fillStyle = "rgba(10,14,20,0.72)";
  ctx.fillRect(left - 1, top - 1, full * (width + 1) + 1, 5);
  for (let k = 0; k < full; k++) {
    ctx.fillStyle = k < one.shown.blood ? "#ffffff" : fade(palette.camp[one.shown.piece.camp], 0.6);
    ctx.fillRect(left + k * (width + 1), top, width, 3);
  }
}

const fullBlood = new Map<string, number>();

export function knowBlood(game: Game): void {
  for (const [kind, row] of Object.entries(game.story.rules.kinds)) fullBlood.set(kind, row.blood);
}

function age(ctx: CanvasRenderingContext2D, one: Token, palette: Palette): void {
  plate(ctx, `${one.shown.age}`, { x: one.at.x, y: one.at.y - one.size - 7 }, 10, palette);
}

function suppressed(ctx: CanvasRenderingContext2D, at: Point, size: number, palette: Palette): void {
  const x = at.x + size * 0.85;
  const y = at.y - size * 0.85;
  const r = Math.max(4.5, size * 0.42);
  ctx.beginPath();
  ctx.moveTo(x, y - r);
  ctx.lineTo(x + r, y + r * 0.8);
  ctx.lineTo(x - r, y + r * 0.8);
  ctx.closePath();
  ctx.fillStyle = palette.warn;
  ctx.fill();
  ctx.lineWidth = 1.2;
  ctx.strokeStyle = "#1d1503";
  ctx.stroke();
}

function rider(ctx: CanvasRenderingContext2D, one: Token, colour: string, palette: Palette): void {
  const at = { x: one.at.x + one.size * 0.95, y: one.at.y + one.size * 0.6 };
  const size = Math.max(5, one.size * 0.45);
  outline(ctx, one.shown.piece.camp, at, size);
  ctx.fillStyle = palette.rim;
  ctx.fill();
  ctx.lineWidth = 1.2;
  ctx.strokeStyle = colour;
  ctx.stroke();
  letter(ctx, one.rider?.piece.letter ?? "", at, size, colour);
}

const widths = new Map<string, number>(); // of plates: to measure a text takes longer than to draw it
const MOST_WIDTHS = 2000;

function plateFont(size: number, weight: number): string {
  return `${weight} ${size}px system-ui, -apple-system, "Segoe UI", sans-serif`;
}

export function plateWidth(ctx: CanvasRenderingContext2D, text: string, size: number, weight = 600): number {
  const key = `${weight} ${size} ${text}`;
  const known = widths.get(key);
  if (known !== undefined) return known;
  ctx.font = plateFont(size, weight);
  const width = ctx.measureText(text).width + size * 0.7;
  if (widths.size >= MOST_WIDTHS) widths.clear();
  widths.set(key, width);
  return width;
}

/** A text on a plate. */
export function plate(ctx: CanvasRenderingContext2D, text: string, at: Point, size: number, palette: Palette, weight = 600): void {
  const width = plateWidth(ctx, text, size, weight);
  ctx.font = plateFont(size, weight);
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.beginPath();
  ctx.roundRect(at.x - width / 2, at.y - size * 0.72, width, size * 1.44, size * 0.4);
  ctx.fillStyle = palette.plate;
  ctx.fill();
  ctx.fillStyle = palette.ink;
  ctx.fillText(text, at.x, at.y + 0.5);
}

/** Wrecks: a cross that fades with the ticks. */
export function drawWrecks(ctx: CanvasRenderingContext2D, state: State, camera: Camera, palette: Palette): void {
  const size = tokenSize(camera) * 0.55;
  for (const shown of state.pieces) {
    if (shown.blood > 0 || shown.cell < 0) continue;
    const age = state.tick - shown.piece.deadAt;
    const at = camera.toScreen(shown.at);
    const strength = 0.4 + 0.6 * Math.max(0, 1 - age / DEAD_TICKS);
    for (const [width, colour] of [[5, fade("#ffffff", strength * 0.8)], [2.6, fade(palette.camp[shown.piece.camp], strength)]] as const) {
      ctx.beginPath();
      ctx.moveTo(at.x - size, at.y - size);
      ctx.lineTo(at.x + size, at.y + size);
      ctx.moveTo(at.x + size, at.y - size);
      ctx.lineTo(at.x - size, at.y + size);
      ctx.lineCap = "round";
      ctx.lineWidth = width;
      ctx.strokeStyle = colour;
      ctx.stroke();
    }
  }
}
