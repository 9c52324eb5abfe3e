// Stories as Python writes them (docs/formats/story.md), and how they are unpacked and read.

import type { ContentsDoc, EntryDoc } from "./contents";
import type { MapDoc } from "./hex";
import { unwoven } from "./packed";

export type Camp = "red" | "blue";
export type View = "referee" | Camp;
export const CAMPS: readonly Camp[] = ["red", "blue"];
export type Changes<T> = (number | T)[]; // [tick, value, tick, value, ...]

export interface OwnDoc {
  hops: number[][]; // [start, end, cell], and where it was broken off the tick
  cell?: Changes<number>;
  blood: Changes<number>;
  hidden?: Changes<number>;
  suppressed?: Changes<number>;
  then?: Changes<number[]>;
  ammo?: Changes<number[]>;
  carrier?: Changes<number>;
  sees?: Changes<number[]>;
  [timer: `${string}_ends`]: Changes<number>;
}

export interface BeliefDoc {
  state?: Changes<number>; // 0 never seen, 1 seen, 2 lost
  cell?: Changes<number>;
  blood?: Changes<number>;
  hidden?: Changes<number>;
  suppressed?: Changes<number>;
  moving?: Changes<number>;
  next?: Changes<number>;
  last?: Changes<number>;
}

export interface EventDoc {
  tick: number;
  kind: string;
  piece: string;
  cell?: string;
  target?: string;
  shooter?: string;
  weapon?: string;
  level?: number;
  cells_apart?: number;
  roll?: number;
  modifiers?: number;
  result?: number;
  losses?: number;
  hit?: boolean;
  chances?: number[];
  expected?: number;
  variance?: number;
  lost?: number;
}

export interface KindDoc {
  value: number;
  blood: number;
  hop_ticks: number;
  sight: Record<string, number>;
  weapons: [string, number, number, number][]; // reach against vehicles, soldiers, aerocraft
}

export interface RulesDoc {
  version: string;
  air_height_m: number;
  hidden_sight_divisor: number;
  concealed_sight_divisor: number;
  kinds: Record<string, KindDoc>;
}

export type OrderDoc = [number, Camp, string[], [string, string][]];
export type Choice = [number, number, number[], number[], string]; // piece, chosen, tasks, Q in thousandths, direction

export interface StoryDoc {
  format: string;
  version: number;
  view: View;
  with?: Camp[];
  scenario: string;
  map: string;
  game_ticks: number;
  net_score: boolean;
  players: Record<Camp, { name: string; kind: string }>;
  roster: [string, string][];
  points: [string, number, number][];
  rules: RulesDoc;
  last: number;
  pieces: Record<string, OwnDoc>;
  beliefs: Partial<Record<Camp, Record<string, BeliefDoc>>>;
  owners: Changes<string>[];
  known_margin: Partial<Record<Camp, Changes<number>>>;
  own_total: Partial<Record<Camp, Changes<number>>>;
  fights: Changes<number[]>;
  bursts: Changes<number[]>;
  rounds: number[][];
  events: EventDoc[];
  orders: OrderDoc[];
  tasks?: string[];
  decisions?: [number, Choice[]][];
  policy: Partial<Record<Camp, { tasks: string[]; decisions: [number, Choice[]][] }>>; // made when it is read
  margin?: Record<Camp, Changes<number>>;
  end?: { tick: number; over: boolean; winner: string | null; margin: Record<Camp, number> };
  seed?: string;
  rewards?: [number, Camp, Record<string, number>][];
}

export type SetupDoc = Pick<StoryDoc, "scenario" | "map" | "game_ticks" | "net_score" | "roster" | "points">;

/** Number of the last change at or before a tick; -1 before the first. */
export function changeAt(list: Changes<unknown>, tick: number): number {
  let low = 0;
  let high = list.length / 2;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((list[2 * middle] as number) <= tick) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The value at a tick; `usual` where a list is left out or has not begun. */
export function valueAt<T>(list: Changes<T> | undefined, tick: number, usual: T): T {
  if (list === undefined) return usual;
  const k = changeAt(list, tick);
  return k < 0 ? usual : (list[2 * k + 1] as T);
}

export function tickOf(list: Changes<unknown>, k: number): number {
  return list[2 * k] as number;
}

async function unpack<T>(packed: string): Promise<T> {
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return JSON.parse(await new Response(stream).text()) as T;
}

function block(id: string): string | null {
  return document.getElementById(id)?.textContent ?? null;
}

/** The contents of a page of many games; null on the page of one. */
export async function loadContents(): Promise<ContentsDoc | null> {
  const packed = block("contents");
  return packed === null ? null : unpack<ContentsDoc>(packed);
}

/** The views of the one game of a page. */
export function viewsOf(game: number): View[] {
  const found = (["referee", ...CAMPS] as View[]).filter((view) => block(`story-${game}-${view}`) !== null);
  return found;
}

export async function loadMap(key: string): Promise<MapDoc> {
  return unpack<MapDoc>(block(`map-${key}`) ?? "");
}

export function loadSetup(key: string): Promise<SetupDoc> {
  return unpack<SetupDoc>(block(`setup-${key}`) ?? "");
}

/** A story of a page of many: its game is one block with all views. */
export async function loadClip(game: number, entry: EntryDoc, view: View): Promise<StoryDoc> {
  const [woven, setup, rules] = await Promise.all([`game-${game}`, `setup-${entry.setup}`, `rules-${entry.rules}`].map((id) => unpack<never>(block(id) ?? "")));
  const shared = { ...(setup as object), rules, players: entry.players };
  const story = unwoven(woven, view, shared);
  if (story.with === undefined) return withPolicy(story);
  return together(story, story.with.map((camp) => withPolicy(unwoven(woven, camp, shared))));
}

export async function loadStory(game: number, view: View): Promise<StoryDoc> {
  const story = await unpack<StoryDoc>(block(`story-${game}-${view}`) ?? "");
  if (story.with === undefined) return withPolicy(story);
  const camps = await Promise.all(story.with.map((camp) => loadStory(game, camp)));
  return together(story, camps);
}

export function withPolicy(story: StoryDoc): StoryDoc {
  const { tasks, decisions, view } = story;
  story.policy = tasks && decisions && view !== "referee" ? { [view]: { tasks, decisions } } : {};
  return story;
}

/** The referee's story: the truth that neither camp knew, and all that the two knew. */
export function together(story: StoryDoc, camps: StoryDoc[]): StoryDoc {
  const merged = { ...camps[0], ...story };
  for (const key of ["pieces", "beliefs", "known_margin", "own_total", "policy"] as const) {
    Object.assign(merged, { [key]: Object.assign({}, ...camps.map((camp) => camp[key])) });
  }
  merged.rounds = camps.flatMap((camp) => camp.rounds);
  merged.orders = camps.flatMap((camp) => camp.orders).sort((a, b) => a[0] - b[0]);
  return merged;
}
