// What happened, in lines: one a shot, with its dice and its luck. Timeline, log and map all read these.

import { cellName, parseCell } from "./hex";
import { CAMPS, type Camp, type EventDoc, valueAt } from "./story";
import { type Game, other } from "./state";

export type Shape = "miss" | "hit" | "dead" | "point" | "sight" | "lost" | "refused" | "round" | "note" | "order" | "choice";
export type Group = "fire" | "sight" | "orders" | "rest";

export interface Entry {
  tick: number;
  camp: Camp; // whose lane it is in
  shape: Shape;
  group: Group;
  text: string;
  brief?: string; // without dice, luck and distance
  luck: number | null; // points more or less than expected, for who fired
  from: number; // cells; -1 none
  to: number;
  dead: boolean;
  result: number; // of a shot: -1 nothing, 0 suppressed, n losses
}

export interface LuckCurve {
  ticks: number[];
  sum: number[]; // points more than expected, after each shot
  sigma: number[];
}

const FIRE = new Set(["shot", "guided", "close_shot", "exit_shot", "mortar_judged"]);
const SAID: Record<string, string> = {
  hidden: "is hidden",
  off: "got off its chariot",
  aboard: "is aboard its chariot",
  getoff_blocked: "could not get off: the cell is full",
  first_contact: "begins a close combat",
  path_blocked: "cannot go on: the next cell is closed",
  released: "is no longer suppressed",
};

export function entriesOf(game: Game): Entry[] {
  const found = [...fire(game), ...sights(game), ...captures(game), ...orders(game)];
  return found.sort((a, b) => a.tick - b.tick);
}

export function spoken(name: string): string {
  return name.replace(":", " ");
}

function entry(tick: number, camp: Camp, shape: Shape, group: Group, text: string, rest: Partial<Entry> = {}): Entry {
  return { tick, camp, shape, group, text, luck: null, from: -1, to: -1, dead: false, result: -1, ...rest };
}

function campOf(name: string): Camp {
  return name.split(":")[0] as Camp;
}

/** Where a piece was before the step that led to a tick, as far as the view knows. */
function cellBefore(game: Game, name: string, tick: number): number {
  const piece = game.byName(name);
  if (!piece) return -1;
  const shown = game.shown(piece, Math.max(0, tick - 1));
  const carrier = shown.carrier >= 0 ? game.shown(game.pieces[shown.carrier], tick - 1) : shown;
  return carrier.cell;
}

/** Who was aboard a piece before the step that led to a tick. */
function ridersOf(game: Game, name: string, tick: number): string[] {
  const carrier = game.byName(name);
  return game.pieces.filter((one) => carrier && game.shown(one, tick - 1).carrier === carrier.index).map((one) => one.name);
}

function* fire(game: Game): Generator<Entry> {
  const { events } = game.story;
  const told = new Set<EventDoc>(); // losses and deaths that stand with a shot
  const same = (a: EventDoc, kind: string, name: string) => a.kind === kind && a.piece === name;
  for (let k = 0; k < events.length; k++) {
    const event = events[k];
    const now = events.slice(k + 1).filter((one) => one.tick === event.tick); // short: events are in order
    if (FIRE.has(event.kind) && event.target) {
      const hurt = [event.target, ...ridersOf(game, event.target, event.tick)];
      for (const kind of ["loss", "suppressed", "dead"]) for (const one of now) if (hurt.some((name) => same(one, kind, name))) told.add(one);
      yield shot(game, event, now.some((one) => same(one, "dead", hurt[0])), hurt.slice(1));
    } else if (event.kind === "mortar_fired" || event.kind === "mortar_landed") {
      const to = parseCell(game.map, event.cell ?? "");
      const landed = event.kind === "mortar_landed";
      const text = `${spoken(event.piece)} mortar ${landed ? `comes down in ${event.cell}${event.hit ? ", on target" : ""}` : `fired at ${event.cell}`}`;
      yield entry(event.tick, campOf(event.piece), "round", "fire", text, { from: cellBefore(game, event.piece, event.tick), to });
    } else if (!told.has(event) && !(event.kind === "suppressed" && events.some((one) => one.tick === event.tick && same(one, "loss", event.piece)))) {
      const line = rest(game, event);
      if (line) yield line;
    }
  }
}

function rest(game: Game, event: EventDoc): Entry | null {
  const camp = campOf(event.piece);
  const to = parseCell(game.map, event.cell ?? "");
  const who = spoken(event.piece);
  if (event.kind === "dead") return entry(event.tick, camp, "dead", "fire", `${who} destroyed`, { to, dead: true });
  if (event.kind === "loss") return entry(event.tick, camp, "hit", "fire", `${who} lost ${event.losses}`, { to });
  if (event.kind === "suppressed") return entry(event.tick, camp, "miss", "fire", `${who} suppressed`, { to, result: 0 });
  return SAID[event.kind] ? entry(event.tick, camp, "note", "rest", `${who} ${SAID[event.kind]}`, { to }) : null;
}

function shot(game: Game, event: EventDoc, dead: boolean, riders: string[]): Entry {
  const from = cellBefore(game, event.shooter ?? event.piece, event.tick);
  const to = parseCell(game.map, event.cell ?? "");
  const result = event.result ?? -1;
  const shape: Shape = dead ? "dead" : result > 0 ? "hit" : "miss";
  const luck = event.expected === undefined || event.lost === undefined ? null : event.lost - event.expected;
  return entry(event.tick, campOf(event.piece), shape, "fire", shotText(game, event, dead, riders), { from, to, luck, dead, result, brief: `${shotHead(event)}: ${harmText(game, event, dead)}` });
}

function shotHead(event: EventDoc): string {
  const weapon = event.kind === "guided" ? "guides HEAVY" : (event.weapon ?? "");
  return `${spoken(event.piece)} ${weapon} → ${spoken(event.target ?? "")}`;
}

function harmText(game: Game, event: EventDoc, dead: boolean): string {
  const result = event.result ?? -1;
  const blood = Math.min(result, game.story.rules.kinds[kindOf(game, event.target ?? "")].blood);
  return dead ? "destroyed" : result > 0 ? `lost ${blood}` : result === 0 ? "suppressed" : "no effect";
}

/** "red tank1 GUN → blue chariot0, 3 cells: expected 7.4, 2d6 = 10 (level 7, +0), lost 2 = 22 points". */
function shotText(game: Game, event: EventDoc, dead: boolean, riders: string[]): string {
  const cells = event.cells_apart === undefined ? "" : `, ${event.cells_apart} ${event.cells_apart === 1 ? "cell" : "cells"}`;
  const head = `${shotHead(event)}${cells}`;
  const harm = harmText(game, event, dead);
  const end = riders.length > 0 && (event.result ?? -1) > 0 ? `${harm}, with ${riders.map((name) => name.split(":")[1]).join(", ")} aboard` : harm;
  if (event.roll === undefined) return `${head}: ${end}`;
  const level = event.kind === "mortar_judged" ? (event.hit ? "on target" : "off target") : `level ${event.level}`;
  const dice = `2d6 = ${event.roll} (${level}, ${signed(event.modifiers ?? 0)})`;
  return `${head}: expected ${event.expected?.toFixed(1)}, ${dice}, ${end}${event.lost ? ` = ${event.lost} points` : ""}`;
}

function kindOf(game: Game, name: string): string {
  return game.byName(name)?.kind ?? "tank";
}

export function signed(value: number, digits = 0): string {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;
}

function* sights(game: Game): Generator<Entry> {
  for (const piece of game.pieces) {
    const { state, cell } = game.belief(piece.camp, piece.name);
    if (!state) continue;
    const seer = other(piece.camp);
    for (let k = 2; k < state.length; k += 2) {
      const [tick, now, before] = [state[k] as number, state[k + 1], state[k - 1]];
      const to = valueAt(cell, tick, -1);
      const place = to < 0 ? "" : ` in ${cellName(game.map, to)}`;
      if (now === 1) {
        const text = `${seer} ${before === 0 ? "sees" : "sees again"} ${spoken(piece.name)}${place}`;
        yield entry(tick, seer, before === 0 ? "sight" : "note", before === 0 ? "sight" : "rest", text, { to });
      } else if (now === 2) {
        const alive = piece.deadAt > tick;
        if (alive) yield entry(tick, seer, "lost", "rest", `${seer} loses sight of ${spoken(piece.name)}`, { to });
      }
    }
  }
}

function* captures(game: Game): Generator<Entry> {
  for (const [k, owner] of game.story.owners.entries()) {
    const [name, cell, value] = game.story.points[k];
    for (let n = 2; n < owner.length; n += 2) {
      const camp = owner[n + 1] as Camp | "green";
      if (camp === "green") continue;
      yield entry(owner[n] as number, camp, "point", "fire", `${camp} takes ${name} (${value} points)`, { to: cell });
    }
  }
}

function* orders(game: Game): Generator<Entry> {
  for (const [tick, camp, given, refused] of game.story.orders) {
    for (const text of given) yield entry(tick, camp, "order", "orders", `${camp} ${text}`);
    for (const [text, why] of refused) yield entry(tick, camp, "refused", "orders", `${camp} ${text}: refused, ${why}`);
  }
  for (const camp of CAMPS) {
    for (const [tick] of game.story.policy[camp]?.decisions ?? []) yield entry(tick, camp, "choice", "orders", `${camp} decides`);
  }
}

/** Running luck of a camp's own shots, with one standard deviation. */
export function luckOf(game: Game, camp: Camp): LuckCurve {
  const curve: LuckCurve = { ticks: [0], sum: [0], sigma: [0] };
  let variance = 0;
  for (const event of game.story.events) {
    if (event.expected === undefined || event.lost === undefined || campOf(event.piece) !== camp) continue;
    variance += event.variance ?? 0;
    curve.ticks.push(event.tick);
    curve.sum.push(curve.sum[curve.sum.length - 1] + event.lost - event.expected);
    curve.sigma.push(Math.sqrt(variance));
  }
  return curve;
}
