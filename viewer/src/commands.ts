// What can be typed: keys, the "/" line, and the address of a moment.

import { type HexMap, parseCell } from "./hex";
import type { Game, Piece } from "./state";
import type { View } from "./story";

export const SPEEDS = [1, 2, 4, 8, 16, 32, 64];

export interface Moment {
  game?: number; // on a page of many
  with?: number; // the game beside it
  t?: number;
  view?: View;
  pick?: string;
  speed?: number;
  cell?: string;
}

/** "#t=577&view=red&pick=red:tank1&speed=8" as values; what is not understood is left out. */
export function readMoment(hash: string): Moment {
  const found = new URLSearchParams(hash.replace(/^#/, ""));
  const moment: Moment = {};
  const tick = Number(found.get("t") ?? Number.NaN);
  const speed = Number(found.get("speed"));
  const view = found.get("view");
  for (const name of ["game", "with"] as const) {
    const number = Number(found.get(name));
    if (Number.isInteger(number) && number > 0) moment[name] = number;
  }
  if (Number.isFinite(tick) && tick >= 0) moment.t = Math.floor(tick);
  if (SPEEDS.includes(speed)) moment.speed = speed;
  if (view === "referee" || view === "red" || view === "blue") moment.view = view;
  const [pick, cell] = [found.get("pick"), found.get("cell")];
  if (pick) moment.pick = pick;
  if (cell) moment.cell = cell;
  return moment;
}

export function writeMoment(moment: Moment): string {
  const parts = Object.entries(moment).filter(([, value]) => value !== undefined);
  return `#${parts.map(([name, value]) => `${name}=${encodeURIComponent(String(value)).replace("%3A", ":")}`).join("&")}`;
}

export type Command =
  | { kind: "seek"; tick: number }
  | { kind: "pick"; piece: Piece }
  | { kind: "cell"; cell: number }
  | { kind: "view"; view: View }
  | { kind: "speed"; speed: number }
  | { kind: "help" }
  | { kind: "unknown"; text: string };

/** One line: "t 577", "577", "tank1", "blue tank1", "0912", "red", "speed 8", "?". */
export function readCommand(text: string, game: Game, map: HexMap, camp: string): Command {
  const words = text.trim().toLowerCase().replace(/^\//, "").split(/[\s:]+/).filter(Boolean);
  const [first, second] = words;
  if (first === "?" || first === "help") return { kind: "help" };
  if (first === "speed" && SPEEDS.includes(Number(second))) return { kind: "speed", speed: Number(second) };
  if (words.length === 1 && parseCell(map, first) >= 0) return { kind: "cell", cell: parseCell(map, first) };
  const number = first === "t" ? second : first;
  if (number !== undefined && /^[0-9]+$/.test(number)) return { kind: "seek", tick: Math.min(game.last, Number(number)) };
  const name = words.length === 2 ? words.join(":") : `${camp}:${first}`;
  const piece = game.byName(name) ?? game.pieces.find((one) => one.short === first);
  if (piece && (words.length === 1 || piece.name === name)) return { kind: "pick", piece };
  if (first === "referee" || first === "red" || first === "blue") return { kind: "view", view: first };
  return { kind: "unknown", text };
}

export const KEYS: [string, string][] = [
  ["space", "play or pause"],
  ["← →", "one tick back, on"],
  ["shift ← →", "75 ticks back, on"],
  ["n p", "next, previous event"],
  ["d", "next decision"],
  ["Home End", "start, end"],
  ["[ ]", "slower, faster"],
  ["1 2 3", "referee, red, blue"],
  ["b", "beliefs: where a side thinks its enemy is"],
  ["g", "fog of a camp's view"],
  ["l", "line of sight of what is picked; of nothing: who sees whom"],
  ["r", "ranges of the picked piece"],
  ["q", "policy of the picked piece"],
  ["f", "follow the picked piece"],
  ["m", "mute the marks of the timeline"],
  ["x", "take the loop away (shift-drag the timeline makes one)"],
  ["+ − 0", "closer, farther, whole map"],
  ["z", "to the pieces"],
  ["s", "save a picture, a film or the events"],
  ["c", "copy a link to this moment"],
  ["/", "type: t 577, tank1, 0912, red, speed 8"],
  ["a", "all games of the page"],
  ["< >", "game before, game after"],
  ["w", "of two games, the other one"],
  ["Esc", "let go of what is picked"],
];
