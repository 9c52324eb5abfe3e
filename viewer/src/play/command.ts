// The "/" line of a game that is played: orders in their own text, and words for the clock.

import { SPEEDS } from "../commands";
import { type HexMap, parseCell } from "../hex";
import type { Game, Piece } from "../state";

export type Typed =
  | { kind: "order"; text: string; then: boolean } // as the engine reads it; a move may name its goal only
  | { kind: "pick"; piece: Piece }
  | { kind: "cell"; cell: number }
  | { kind: "go" }
  | { kind: "pause" }
  | { kind: "step" } // one tick
  | { kind: "next" } // event
  | { kind: "decision" }
  | { kind: "undo" }
  | { kind: "hint" }
  | { kind: "speed"; speed: number }
  | { kind: "help" }
  | { kind: "unknown"; text: string };

const WORDS: Record<string, Typed> = {
  go: { kind: "go" }, run: { kind: "go" }, start: { kind: "go" }, pause: { kind: "pause" }, stop: { kind: "pause" }, next: { kind: "next" }, event: { kind: "next" },
  step: { kind: "step" }, decision: { kind: "decision" }, undo: { kind: "undo" }, back: { kind: "undo" }, hint: { kind: "hint" }, hints: { kind: "hint" }, "?": { kind: "help" }, help: { kind: "help" },
};

/** One line: "tank0 move 1234", "then tank0 hide", "tank0", "1234", "go", "step 10", "speed 8". */
export function readTyped(text: string, game: Game, map: HexMap, camp: string): Typed {
  const words = text.trim().replace(/^\//, "").split(/\s+/).filter(Boolean);
  const then = words[0]?.toLowerCase() === "then";
  if (then) words.shift();
  const first = (words[0] ?? "").toLowerCase();
  const [second] = words.slice(1);
  const piece = game.byName(first.includes(":") ? first : `${camp}:${first}`);
  if (piece && words.length > 1) return { kind: "order", text: [piece.short, ...words.slice(1)].join(" "), then };
  if (piece) return { kind: "pick", piece };
  if (words.length === 1 && parseCell(map, first) >= 0) return { kind: "cell", cell: parseCell(map, first) };
  if (words.length === 1 && WORDS[first]) return WORDS[first];
  if (first === "speed" && SPEEDS.includes(Number(second))) return { kind: "speed", speed: Number(second) };
  return { kind: "unknown", text };
}

export const KEYS: [string, string][] = [
  ["1 – 9", "pick a piece of yours"],
  ["← ↑ ↓ →", "move the cell cursor (shift: five cells)"],
  ["Enter", "at the cursor: plan; else: give the orders and run"],
  ["shift Enter", "plan for after what is planned (shift-click does the same)"],
  ["Backspace", "take back the last order that waits"],
  ["a", "what the piece can do: the list of its actions"],
  ["space", "run or pause"],
  [". n d", "one tick, to the next event, to the next decision"],
  ["[ ]", "slower, faster"],
  ["h o s", "hide, occupy, stop"],
  ["m", "mortar: the cells that it reaches"],
  ["l r g", "line of sight, ranges, fog"],
  ["c", "show on the map why the clock stopped"],
  ["f", "follow the picked piece"],
  ["e i t q", "panels: orders, pieces, log, hints"],
  ["p", "when the clock stops by itself"],
  ["Home End", "look back to the start; to now"],
  ["+ − 0", "closer, farther, whole map"],
  ["/", "type: tank0 move 1234, then tank0 hide, go"],
  ["Esc", "let go of the cursor, then of the piece"],
];
