// Ways and shots that are planned, as they are drawn and told.

import { cellName, centre, parseCell } from "../hex";
import { type Piece, type Shown, hopAt } from "../state";
import { cellsOf, goalOf, readOrder } from "./orders";
import type { PlannedShot, PlannedWay } from "./plandraw";
import type { Play } from "./play";

const FIRE = new Set(["shoot", "guide-shoot", "indirect-shoot"]);

interface Course {
  cells: number[];
  arrives: number; // tick; -1 not known
}

/** All of a piece's way: the order that waits, or the hops under way, and the waypoints after them. */
export function courseOf(play: Play, piece: Piece): Course {
  const { map, state } = play.session;
  const steps = state.plans[piece.short] ?? [];
  const goals = steps.map((step) => goalOf(map, step)).filter((cell) => cell >= 0);
  const order = state.tray[piece.short];
  const course = order === undefined ? hopsOf(play, piece) : { cells: cellsOf(map, cellOf(play, piece), order), arrives: -1 };
  const first = goals.shift() ?? course.cells[course.cells.length - 1];
  if (first === undefined) return course;
  let whole = course.arrives >= 0 ? longer(play, piece, course, first) : fromHere(play, piece, course, first);
  for (const goal of goals) whole = longer(play, piece, whole, goal);
  return whole;
}

function cellOf(play: Play, piece: Piece): number {
  return play.session.game.shown(piece, play.session.tick).cell;
}

/** The hops under way, and when they end: the present one is dated, the others take what the ground takes. */
function hopsOf(play: Play, piece: Piece): Course {
  const { game, tick } = play.session;
  const hop = piece.own && hopAt(piece.own, tick);
  const cells = game.path(piece, tick);
  if (!hop || cells.length === 0) return { cells: [], arrives: -1 };
  const rest = longer(play, piece, { cells: [cells[0]], arrives: hop[1] }, cells[cells.length - 1]);
  return { cells, arrives: rest.arrives };
}

/** From where the piece stands: the server knows when it can set out. */
function fromHere(play: Play, piece: Piece, course: Course, goal: number): Course {
  const leg = play.known.leg(piece.short, null, goal);
  return { cells: leg?.cells ?? course.cells, arrives: leg?.arrives ?? -1 };
}

/** A way that goes on to another cell. */
function longer(play: Play, piece: Piece, course: Course, goal: number): Course {
  const end = course.cells[course.cells.length - 1] ?? cellOf(play, piece);
  if (end === goal) return course;
  const leg = play.known.leg(piece.short, end, goal);
  if (!leg) return { ...course, arrives: -1 }; // not known yet
  return { cells: [...course.cells, ...leg.cells], arrives: course.arrives < 0 ? -1 : course.arrives + leg.arrives - leg.start };
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
