// What stands where at a tick: a pure function of a story. Everything that is drawn or said comes from here.

import { centre, type HexMap, type Point } from "./hex";
import { type BeliefDoc, CAMPS, type Camp, type Changes, type OwnDoc, type StoryDoc, tickOf, valueAt, type View } from "./story";

export interface Piece {
  index: number;
  name: string; // "red:tank0"
  short: string; // "tank0"
  camp: Camp;
  kind: string;
  letter: string;
  own: OwnDoc | null; // where the view has it in full
  cells: Changes<number>;
  deadAt: number; // Infinity: it lives to the end
}

export type How = "own" | "seen" | "lost" | "never";

export interface Shown {
  piece: Piece;
  how: How;
  cell: number; // -1: nowhere that is known
  at: Point; // where it is drawn, between cells while it hops
  blood: number;
  hidden: boolean;
  suppressed: boolean;
  carrier: number; // index, -1 none
  next: number; // the cell that it is on its way to, -1 none
  moving: boolean;
  age: number; // ticks since it was last seen; 0 where it is seen
}

export interface State {
  tick: number;
  pieces: Shown[];
  owners: string[];
  margin: Partial<Record<Camp, number>>; // in a camp's view as the camp knows it
  fights: number[];
  bursts: number[];
}

export class Game {
  readonly pieces: Piece[];
  readonly view: View;
  readonly last: number;

  constructor(
    readonly story: StoryDoc,
    readonly map: HexMap,
  ) {
    this.view = story.view;
    this.last = story.last;
    this.pieces = story.roster.map(([name, kind], index) => this.piece(name, kind, index));
  }

  private piece(name: string, kind: string, index: number): Piece {
    const [camp, short] = name.split(":") as [Camp, string];
    const own = this.story.pieces[name] ?? null;
    const blood = own?.blood ?? this.belief(camp, name).blood;
    const k = blood ? blood.length / 2 - 1 : -1;
    const deadAt = blood && k >= 0 && blood[2 * k + 1] === 0 ? tickOf(blood, k) : Infinity;
    return { index, name, short, camp, kind, letter: kind[0].toUpperCase(), own, cells: own ? cellsOf(own) : [], deadAt };
  }

  /** What the other camp believes of a piece. */
  belief(camp: Camp, name: string): BeliefDoc {
    return this.story.beliefs[other(camp)]?.[name] ?? {};
  }

  byName(name: string): Piece | undefined {
    return this.pieces.find((piece) => piece.name === name);
  }

  /** still: pieces stand in their cells, and jump to the next when they arrive. */
  at(time: number, still = false): State {
    const tick = Math.floor(time);
    const { story } = this;
    const margins = story.margin ?? story.known_margin;
    const margin: Partial<Record<Camp, number>> = {};
    for (const camp of CAMPS) {
      if (margins[camp]) margin[camp] = valueAt(margins[camp], tick, 0);
    }
    return {
      tick,
      pieces: this.pieces.map((piece) => {
        const shown = this.shown(piece, time);
        return still && shown.cell >= 0 ? { ...shown, at: centre(this.map, shown.cell) } : shown;
      }),
      owners: story.owners.map((owner) => valueAt(owner, tick, "green")),
      margin,
      fights: valueAt(story.fights, tick, []),
      bursts: valueAt(story.bursts, tick, []),
    };
  }

  shown(piece: Piece, time: number): Shown {
    return piece.own ? this.shownOwn(piece, piece.own, time) : this.believed(piece, time);
  }

  private shownOwn(piece: Piece, own: OwnDoc, time: number): Shown {
    const tick = Math.floor(time);
    const cell = valueAt(piece.cells, tick, -1);
    const hop = hopAt(own, time);
    const place = cell < 0 ? { x: 0, y: 0 } : centre(this.map, cell);
    return {
      piece,
      how: "own",
      cell,
      at: hop ? between(place, centre(this.map, hop[2]), (time - hop[0]) / (hop[1] - hop[0])) : place,
      blood: valueAt(own.blood, tick, 0),
      hidden: valueAt(own.hidden, tick, 0) === 1,
      suppressed: valueAt(own.suppressed, tick, 0) === 1,
      carrier: valueAt(own.carrier, tick, -1),
      next: hop ? hop[2] : -1,
      moving: hop !== null,
      age: 0,
    };
  }

  /** A piece as the other camp believes it to be. */
  believed(piece: Piece, time: number): Shown {
    const tick = Math.floor(time);
    const belief = this.belief(piece.camp, piece.name);
    const state = valueAt(belief.state, tick, 0);
    const cell = state === 0 ? -1 : valueAt(belief.cell, tick, -1);
    return {
      piece,
      how: (["never", "seen", "lost"] as const)[state],
      cell,
      at: cell < 0 ? { x: 0, y: 0 } : centre(this.map, cell),
      blood: state === 0 ? this.story.rules.kinds[piece.kind].blood : valueAt(belief.blood, tick, 0),
      hidden: state === 1 && valueAt(belief.hidden, tick, 0) === 1,
      suppressed: state === 1 && valueAt(belief.suppressed, tick, 0) === 1,
      carrier: -1,
      next: state === 1 ? valueAt(belief.next, tick, -1) : -1,
      moving: state === 1 && valueAt(belief.moving, tick, 0) === 1,
      age: state === 2 ? tick - valueAt(belief.last, tick, tick) : 0,
    };
  }

  /** Enemies that a camp has lost sight of, where it believes them. */
  ghosts(camp: Camp, time: number): Shown[] {
    const lost = this.pieces.filter((piece) => piece.camp !== camp).map((piece) => this.believed(piece, time));
    return lost.filter((one) => one.how === "lost" && one.blood > 0);
  }

  /** Names of the pieces that see a piece now. */
  seenBy(piece: Piece, tick: number): Piece[] {
    return this.pieces.filter((one) => one.own && valueAt(one.own.sees, tick, []).includes(piece.index));
  }

  /** The enemies that a piece sees itself. */
  seenFrom(piece: Piece, state: State): Shown[] {
    return valueAt(piece.own?.sees, state.tick, []).map((index) => state.pieces[index]);
  }

  path(piece: Piece, tick: number): number[] {
    if (!piece.own) return [];
    const hop = hopAt(piece.own, tick);
    return [...(hop ? [hop[2]] : []), ...valueAt(piece.own.then, tick, [])];
  }

  doing(piece: Piece, tick: number): string {
    const own = piece.own;
    if (!own) return "";
    if (valueAt(own.blood, tick, 0) === 0) return "destroyed";
    if (valueAt(own.carrier, tick, -1) >= 0) return "aboard";
    const runs = (timer: string) => valueAt(own[`${timer}_ends`], tick, 0) > tick;
    if (runs("hide")) return "hiding";
    if (runs("board")) return "boarding";
    if (runs("decompress")) return "decompressing";
    if (this.path(piece, tick).length > 0) return "moving";
    return runs("stop") ? "stopping" : "settled";
  }
}

export function other(camp: Camp): Camp {
  return camp === "red" ? "blue" : "red";
}

/** Where a piece stood: its hops, and what they do not explain. */
function cellsOf(own: OwnDoc): Changes<number> {
  const hops = own.hops.filter((hop) => hop.length === 3).map((hop) => [hop[1], hop[2]]);
  const jumps: number[][] = [];
  for (let k = 0; own.cell && k < own.cell.length; k += 2) jumps.push([own.cell[k], own.cell[k + 1]]);
  return [...hops, ...jumps].sort((a, b) => a[0] - b[0]).flat(); // stable: a jump counts after a hop of its tick
}

/** The hop under way. */
export function hopAt(own: OwnDoc, time: number): number[] | null {
  let low = 0;
  let high = own.hops.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (own.hops[middle][0] <= time) low = middle + 1;
    else high = middle;
  }
  const hop = own.hops[low - 1];
  return hop && time < (hop[3] ?? hop[1]) ? hop : null;
}

function between(a: Point, b: Point, share: number): Point {
  return { x: a.x + (b.x - a.x) * share, y: a.y + (b.y - a.y) * share };
}
