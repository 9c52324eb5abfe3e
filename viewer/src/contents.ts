// What a page of many games shows before one is opened (docs/formats/story.md), and which games can be compared.

import type { Camp, View } from "./story";

export interface EntryDoc {
  name: string;
  players: Record<Camp, { name: string; kind: string }>;
  scenario: string;
  map: string;
  setup: string;
  rules: string;
  views: View[];
  last: number;
  margin: Partial<Record<Camp, number>>;
  owners: string[];
  tokens: [number, number][]; // piece, cell
  seed?: string;
  winner?: string | null;
}

export type Estimate = [number, number, number]; // value, low, high

export interface CurveDoc {
  games: number; // of an evaluation
  rows: [number, number, Estimate, Estimate][]; // env steps, game, win rate, margin
}

export interface CellDoc {
  rate: Estimate;
  games: number;
  game?: number;
  episode?: number;
  seed?: number;
}

export interface TableDoc {
  name: string;
  red: string[];
  blue: string[];
  cells: (CellDoc | null)[][];
}

export interface KeptDoc {
  name: string;
  parent: string | null;
  rate: number;
}

export interface ContentsDoc {
  title: string;
  kind: "games" | "compare" | "album" | "league";
  games: EntryDoc[];
  curve?: CurveDoc;
  tables?: TableDoc[];
  lineage?: Record<string, KeptDoc[][]>; // by colour and iteration, the best first
}

/** Why two games cannot be shown side by side; null where they can. */
export function whyApart(a: EntryDoc, b: EntryDoc): string | null {
  if (a === b) return "the same game";
  if (a.map !== b.map) return "another map";
  if (a.setup !== b.setup) return "another scenario";
  if (a.rules !== b.rules) return "other rules";
  return null;
}

/** "red +171, blue −171": the margins at the end, as far as the page knows them. */
export function resultOf(entry: EntryDoc): string {
  if (entry.winner === "draw") return "a draw";
  return entry.winner ? `${entry.winner} wins` : "";
}
