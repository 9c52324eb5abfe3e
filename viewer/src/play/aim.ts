// What would happen if the picked piece were sent to the cell under the pointer or the cursor.

import { cellName, centre } from "../hex";
import { spoken } from "../log";
import { ground } from "../piecespanel";
import type { Shown } from "../state";
import { endOf, percent, readOrder, sayChances, sayPoints } from "./orders";
import type { LookDoc, MortarDoc, PathDoc, ShotDoc } from "./protocol";
import type { Preview } from "./plandraw";
import type { Play } from "./play";
import { courseOf } from "./ways";
import { Refused } from "./wire";

const LEAST_POINTS = 0.05; // a shot that is worth telling

export interface Aim {
  cell: number;
  lines: string[]; // what would come of it
  steps: string[] | null; // what is planned by a click; null: nothing
  then: boolean; // after what is planned already
  preview: Preview | null;
}

/** Where the picked piece stands, or will stand when its plan is done. */
export function startOf(play: Play, then: boolean): number {
  const { picked, session } = play;
  if (!picked) return -1;
  const here = session.game.shown(picked, session.tick).cell;
  const { tray, plans } = session.state;
  return then ? endOf(session.map, here, tray[picked.short], plans[picked.short] ?? []) : here;
}

export function aimOf(play: Play, cell: number, then: boolean): Aim | null {
  const { picked } = play;
  if (!picked || cell < 0 || !play.canOrder) return null;
  const after = then && play.hasPlan(picked.short);
  const enemy = play.enemyIn(cell);
  if (play.mortar && play.mortarGroup(cell)) return mortarAim(play, cell, after);
  if (enemy) return shotAim(play, cell, enemy, after);
  if (cell === startOf(play, after)) return { cell, lines: [`${picked.short} ${after ? "will stand" : "is"} here`], steps: null, then: after, preview: null };
  return wayAim(play, cell, after);
}

function wayAim(play: Play, cell: number, then: boolean): Aim {
  const { picked, session } = play;
  const short = picked?.short ?? "";
  const path = play.pathTo(cell, then);
  const steps = [`${short} go ${cellName(session.map, cell)}`];
  if (path === undefined) return { cell, lines: [`${cellName(session.map, cell)} …`], steps, then, preview: null };
  if (path instanceof Refused) return { cell, lines: [path.message], steps: null, then, preview: null };
  const lines = [wayText(play, path, then), watchText(path, cell), ...fireText(play.thoughtOf(cell))];
  const eyes = watchers(path, cell).map((name) => session.game.byName(name)).filter((piece) => piece !== undefined);
  const { state } = play.scene();
  const preview = { from: centre(session.map, startOf(play, then)), cells: path.cells, lines, end: cell, eyes: eyes.map((piece) => state.pieces[piece.index]).filter((one) => one.cell >= 0).map((one) => one.at) };
  return { cell, lines, steps, then, preview };
}

/** How far, and when it is there: after a plan the server counts from now, and the plan's own end is added. */
function wayText(play: Play, path: PathDoc, then: boolean): string {
  const { map, tick } = play.session;
  const count = `${path.cells.length} ${path.cells.length === 1 ? "cell" : "cells"}`;
  const planned = then && play.picked ? courseOf(play, play.picked).arrives : -1;
  const arrives = planned < 0 ? path.arrives : planned + path.arrives - path.start;
  if (then && planned < 0) return `${cellName(map, path.goal)}: ${count}, ${path.arrives - path.start} ticks more`;
  return `${cellName(map, path.goal)}: ${count}, there at tick ${arrives} (+${arrives - tick})`;
}

function watchers(path: PathDoc, cell: number): string[] {
  return path.watched.find(([where]) => where === cell)?.[1] ?? [];
}

function watchText(path: PathDoc, cell: number): string {
  const there = watchers(path, cell);
  const onTheWay = path.watched.filter(([where]) => where !== cell).length;
  const way = onTheWay ? `${onTheWay} ${onTheWay === 1 ? "cell" : "cells"} of the way in sight` : "";
  const end = there.length ? `in sight of ${there.map(spoken).join(", ")}` : "";
  return [end, way].filter(Boolean).join("; ") || "in sight of no known enemy";
}

/** The best shot from there. */
function fireText(look: LookDoc | undefined): string[] {
  const best = bestOf(look?.shots ?? []);
  return best && best.points >= LEAST_POINTS ? [`could fire from there: ${readOrder(best.order).words[1] ?? ""} at ${spoken(best.target)}, ${sayPoints(best.points)}`] : [];
}

export function bestOf(shots: ShotDoc[]): ShotDoc | undefined {
  return [...shots].sort((a, b) => b.points - a.points)[0];
}

function shotAim(play: Play, cell: number, enemy: Shown, then: boolean): Aim {
  const look = then ? play.thoughtOf(startOf(play, true)) : play.lookNow();
  const { name } = enemy.piece;
  if (look === undefined) return { cell, lines: [`${spoken(name)} …`], steps: null, then, preview: null };
  const shot = bestOf(look.shots.filter((one) => one.target === name));
  if (!shot) return { cell, lines: [spoken(name), whyNot(look, name)], steps: null, then, preview: null };
  const lines = [`${readOrder(shot.order).words[1]} at ${spoken(name)}, level ${shot.level}: ${sayPoints(shot.points)} expected`, sayChances(shot.chances)];
  return { cell, lines, steps: [shot.order], then, preview: null };
}

/** Why a target cannot be fired at: the engine's sentence, or that no weapon fits. */
function whyNot(look: LookDoc, target: string): string {
  const found = look.impossible.find(([order]) => order.includes(target));
  return found ? found[1] : "no weapon of this piece can fire at it";
}

function mortarAim(play: Play, cell: number, then: boolean): Aim {
  const group = play.mortarGroup(cell);
  const name = cellName(play.session.map, cell);
  return { cell, lines: group ? [`Mortar at ${name}: ${MORTAR_CLASSES[group.class]}`, oddsText(group)] : [], steps: [`${play.picked?.short} indirect-shoot ${name}`], then, preview: null };
}

export const MORTAR_CLASSES = ["nobody looks at the cell", "an own piece looks at the cell", "an own piece sees an enemy in it"];

function oddsText(group: MortarDoc): string {
  const odds: [string, number][] = [["on target", group.hit], ["beside it in the cell", group.off_target], ["elsewhere", group.scatter]];
  return odds.filter(([, chance]) => chance >= 0.005).map(([where, chance]) => `${where} ${percent(chance)}`).join(", ");
}

/** The same for somebody who does not see the map. */
export function sayCell(play: Play, cell: number): string {
  const { map } = play.session;
  const here = play.scene().state.pieces.filter((one) => one.cell === cell && one.blood > 0 && one.carrier < 0);
  const point = play.session.story.points.find(([, where]) => where === cell);
  const who = here.map((one) => `${spoken(one.piece.name)}${one.how === "lost" ? `, seen ${one.age} ticks ago` : ""}`);
  return [cellName(map, cell), `${map.level[cell] * map.gradeM} m`, ground(map.bits[cell]), point ? `point ${point[0]}` : "", ...who].filter(Boolean).join(", ");
}
