// What a frame is drawn of: the state at a time, what is picked, and what the panels may ask for.

import type { Entry, LuckCurve } from "./log";
import type { Sight } from "./los";
import type { Palette } from "./palette";
import type { Game, Piece, State } from "./state";
import type { Camp } from "./story";

export interface Scene {
  game: Game;
  state: State;
  time: number;
  picked: Piece | null;
  cell: number; // picked; -1 none
  hover: number; // cell under the pointer; -1 none
  entries: Entry[];
  luck: Partial<Record<Camp, LuckCurve>>;
  palette: Palette;
  ratio: number;
  sight: Sight;
  pick(piece: Piece): void;
  seek(tick: number): void;
  point(entry: Entry | null): void;
}

export type Tab = "pieces" | "log" | "policy";
