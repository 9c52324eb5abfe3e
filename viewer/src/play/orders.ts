// Orders as texts: what they are called, where they lead, and what a piece has planned.

import { type HexMap, isCellName, neighbour, parseCell } from "../hex";

const DIRECTIONS = ["W", "SW", "SE", "E", "NE", "NW"];
const SAYS: Record<string, string> = {
  stop: "Stop", hide: "Hide", occupy: "Occupy this point", decompress: "Recover from suppression", "get-on": "Get on", "get-off": "Set down",
  shoot: "Shoot at", "guide-shoot": "Guide a missile to", "indirect-shoot": "Mortar at", move: "Move to", go: "Go to", null: "Nothing new",
};

export interface Order {
  piece: string;
  verb: string;
  words: string[];
}

export function readOrder(text: string): Order {
  const [piece = "", verb = "", ...words] = text.split(" ");
  return { piece, verb, words };
}

/** "Shoot at blue tank0 with GUN", "Go to 1234". */
export function sayOrder(text: string): string {
  const { verb, words } = readOrder(text);
  const says = SAYS[verb] ?? verb;
  const what = words.map((word) => word.replace(":", " "));
  if (verb === "shoot") return `${says} ${what[0] ?? ""} with ${what[1] ?? ""}`;
  if (verb === "guide-shoot") return `${says} ${what[0] ?? ""} from ${what[1] ?? ""}`;
  if (verb === "move") return `${says} ${what[what.length - 1] ?? ""}`;
  return [says, ...what].join(" ");
}

/** The cells of a move, without the first; cell names and directions both lead on. */
export function cellsOf(map: HexMap, start: number, text: string): number[] {
  const { verb, words } = readOrder(text);
  if (verb !== "move") return [];
  const cells: number[] = [];
  let here = start;
  for (const word of words) {
    const direction = DIRECTIONS.indexOf(word.toUpperCase());
    here = direction < 0 ? parseCell(map, word) : neighbour(map, here, direction);
    if (here < 0) break;
    cells.push(here);
  }
  return cells;
}

/** The cell that a step leads to; -1 where it leads nowhere. */
export function goalOf(map: HexMap, text: string): number {
  const { verb, words } = readOrder(text);
  return verb === "go" ? parseCell(map, words[0] ?? "") : -1;
}

/** Where a piece will stand when it has done all that is planned. */
export function endOf(map: HexMap, here: number, order: string | undefined, steps: string[]): number {
  const moved = order === undefined ? [] : cellsOf(map, here, order);
  const goals = steps.map((step) => goalOf(map, step)).filter((cell) => cell >= 0);
  return goals[goals.length - 1] ?? moved[moved.length - 1] ?? here;
}

/** What was typed, as a step: a move to one cell is a way there. */
export function stepOf(text: string): string {
  const { piece, verb, words } = readOrder(text);
  const far = verb.toLowerCase() === "move" && words.length === 1 && isCellName(words[0]);
  return far ? `${piece} go ${words[0]}` : [piece, verb.toLowerCase(), ...words].join(" ");
}

/** Chances in five classes: nothing, suppressed, 1, 2, 3 and more losses. */
export function classes(chances: number[]): number[] {
  const [nothing = 0, suppressed = 0, one = 0, two = 0, ...more] = chances;
  return [nothing, suppressed, one, two, more.reduce((a, b) => a + b, 0)];
}

export const CLASS_NAMES = ["nothing", "suppressed", "1 lost", "2 lost", "3 or more lost"];

export function percent(chance: number): string {
  return `${Math.round(chance * 100)}\u00a0%`;
}

/** "nothing 31 %, suppressed 29 %, 1 lost 25 %"; what cannot happen is left out. */
export function sayChances(chances: number[]): string {
  return classes(chances).map((chance, k) => [chance, CLASS_NAMES[k]] as const).filter(([chance]) => chance >= 0.005).map(([chance, name]) => `${name} ${percent(chance)}`).join(", ");
}

/** Expected points; small ones are not told as none. */
export function sayPoints(points: number): string {
  return `${points.toFixed(points < 1 ? 2 : 1)} points`;
}
