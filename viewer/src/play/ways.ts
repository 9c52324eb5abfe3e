// Ways and shots that are planned, as they are drawn and told.

import { cellName, centre, parseCell } from "../hex";
import type { Piece, Shown } from "../state";
import { cellsOf, goalOf, readOrder } from "./orders";
import type { PlannedShot, PlannedWay } from "./plandraw";
import type { Play } from "./play";

const FIRE = new Set(["shoot", "guide-shoot", "indirect-shoot"]);

interface Course {
  cells: number[];
  arrives: number; // tick; -1 not known
}

/** All of a piece's way: the order that waits, the hops under way, and the waypoints after them. */
export function courseOf(play: Play, piece: Piece): Course {
  const { session } = play;
  const { map, game, tick } = session;
  const here = game.shown(piece, tick).cell;
  const order = session.state.tray[piece.short];
  const course: Course = { cells: order ? cellsOf(map, here, order) : [], arrives: -1 };
  if (course.cells.length === 0 && readOrder(order ?? "").verb !== "stop") course.cells = game.path(piece, tick);
  const goals = (session.state.plans[piece.short] ?? []).map((step) => goalOf(map, step)).filter((cell) => cell >= 0);
  for (const [k, goal] of goals.entries()) addLeg(play, piece, course, goal, k === 0);
  const last = course.cells[course.cells.length - 1];
  if (goals.length === 0 && last !== undefined) course.arrives = play.known.leg(piece.short, null, last)?.arrives ?? -1;
  return course;
}

function addLeg(play: Play, piece: Piece, course: Course, goal: number, first: boolean): void {
  const end = course.cells[course.cells.length - 1] ?? -1;
  const leg = play.known.leg(piece.short, first ? null : end, goal);
  if (leg && first) course.arrives = leg.arrives;
  else if (leg && course.arrives >= 0) course.arrives += leg.arrives - leg.start;
  if (end === goal || !leg) return;
  course.cells = first && end < 0 ? leg.cells : [...course.cells, ...(first ? play.known.leg(piece.short, end, goal)?.cells ?? [] : leg.cells)];
}

export function waysOf(play: Play): PlannedWay[] {
  const { session } = play;
  if (session.over) return [];
  const state = play.scene().state;
  const found: PlannedWay[] = [];
  for (const piece of play.own()) {
    const shown = state.pieces[piece.index];
    if (shown.blood === 0 || shown.carrier >= 0 || (!play.hasPlan(piece.short) && piece.index !== play.picked?.index)) continue;
    const { cells, arrives } = courseOf(play, piece);
    const note = arrives >= 0 ? `${cellName(session.map, cells[cells.length - 1] ?? shown.cell)} at ${arrives}` : "";
    if (cells.length) found.push({ from: shown.at, cells, note, picked: piece.index === play.picked?.index });
  }
  return found;
}

export function shotsOf(play: Play): PlannedShot[] {
  const { session } = play;
  const state = play.scene().state;
  const found: PlannedShot[] = [];
  for (const piece of play.own()) {
    const orders = [session.state.tray[piece.short], ...(session.state.plans[piece.short] ?? [])];
    let from = state.pieces[piece.index].at;
    for (const text of orders) {
      if (text === undefined) continue;
      const goal = goalOf(session.map, text);
      if (goal >= 0) from = centre(session.map, goal);
      const to = FIRE.has(readOrder(text).verb) ? aimedAt(play, text, state.pieces) : null;
      if (to) found.push({ from, to, note: "", picked: piece.index === play.picked?.index });
    }
  }
  return found;
}

function aimedAt(play: Play, text: string, pieces: Shown[]) {
  const word = readOrder(text).words[0] ?? "";
  const cell = parseCell(play.session.map, word);
  if (cell >= 0) return centre(play.session.map, cell);
  const target = play.session.game.byName(word);
  return target && pieces[target.index].cell >= 0 ? pieces[target.index].at : null;
}
