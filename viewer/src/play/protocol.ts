// What page and server say to each other (docs/formats/play.md), and how a change of the story is read.

import type { MapDoc } from "../hex";
import type { Camp, StoryDoc } from "../story";

export const VERSION = 1;

export type Change = { [name: string]: Change } | ["=", unknown] | ["+", number, unknown[]] | ["-"];

/** The value after a change; the value itself is left as it is. */
export function changed<T>(value: T, change: Change): T {
  if (Array.isArray(change)) return (change[0] === "=" ? change[1] : kept(value, change as ["+", number, unknown[]])) as T;
  const next: Record<string, unknown> = { ...(value as object) };
  for (const [name, one] of Object.entries(change)) {
    if (Array.isArray(one) && one[0] === "-") delete next[name];
    else next[name] = changed(next[name], one);
  }
  return next as T;
}

/** The first entries of a list, and those that follow them now. */
function kept(value: unknown, [, count, more]: ["+", number, unknown[]]): unknown[] {
  return ((value as unknown[] | undefined) ?? []).slice(0, count).concat(more);
}

export interface ClockDoc {
  tick: number;
  end: number;
  running: boolean;
  speed: number;
  over: boolean;
}

export interface StopsDoc {
  first_sight: boolean;
  own_loss: boolean;
  idle: boolean;
}

export interface StateDoc {
  clock: ClockDoc;
  stops: StopsDoc;
  tray: Record<string, string>; // by piece, the order of the next tick
  plans: Record<string, string[]>; // what comes after it
  undo: number;
  hints: { policy: string | null; used: number };
}

export interface LadderDoc {
  rungs: { name: string; won: number; games: number; elo: number | null; elo_range: [number, number] | null }[];
  rung: number; // that is played next
  elo: number | null; // of the person
  elo_range: [number, number] | null;
}

export interface OverDoc {
  say: "over";
  result: "won" | "lost" | "drawn";
  margin: Record<Camp, number>;
  hints: number;
  after: string;
  replay: string;
  file: string;
  ladder: LadderDoc | null;
}

export interface HelloDoc extends StateDoc {
  say: "hello";
  version: number;
  role: "commands" | "reads along";
  camp: Camp;
  name: string;
  opponent: string;
  scenario: string;
  map: MapDoc;
  story: StoryDoc;
  ladder: LadderDoc | null;
  over: OverDoc | null;
}

export interface NowDoc extends StateDoc {
  say: "now";
  story: Change;
  stopped: string | null;
  refused: [string, string, string][]; // piece, order, sentence
}

export interface ShotDoc {
  order: string;
  target: string;
  level: number;
  chances: number[]; // of nothing, of suppression, of 1, 2, ... losses
  points: number;
  ago: number;
}

export interface MortarDoc {
  class: number;
  hit: number;
  off_target: number;
  scatter: number;
  cells: number[];
}

export interface LookDoc {
  piece: string;
  at: number;
  planned: boolean;
  orders: string[];
  shots: ShotDoc[];
  mortar: MortarDoc[];
  impossible: [string, string][];
}

export interface PathDoc {
  piece: string;
  goal: number;
  start: number;
  cells: number[];
  ticks: number[];
  arrives: number;
  watched: [number, string[]][];
}

export interface HintDoc {
  piece: string;
  chosen: number;
  tasks: string[];
  values: number[];
  used: number;
}

export interface Answers {
  look: LookDoc;
  path: PathDoc;
  hint: HintDoc;
  plan: object;
  undo: object;
  cancel: object;
  run: object;
  pause: object;
  step: object;
  stops: object;
  finish: object;
}

export type Ask = keyof Answers;
export type Fields = Record<string, unknown>;
export type Said = HelloDoc | NowDoc | OverDoc;
