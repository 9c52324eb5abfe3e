// Line of sight: the one rule that exists twice (hexwar_sb3/maps/sightlines.py). test/los.json, made by Python, guards it.

import { CONCEALED, cellOf, cellsWithin, cubeOf, type HexMap } from "./hex";

const VOID_TOP_M = 1_000_000;

function nearest(a: number, n: number, up: boolean): number {
  return up ? Math.floor((2 * a + n) / (2 * n)) : -Math.floor((n - 2 * a) / (2 * n));
}

/** Cell i of the line to an offset; ties are rounded up or down. */
function sample(dq: number, dr: number, i: number, up: boolean): [number, number] {
  const ds = -dq - dr;
  const n = Math.max(Math.abs(dq), Math.abs(dr), Math.abs(ds));
  if (Math.abs(dq) === n) return [(dq / n) * i, nearest(dr * i, n, up)];
  if (Math.abs(dr) === n) return [nearest(dq * i, n, up), (dr / n) * i];
  const q = nearest(dq * i, n, up);
  return [q, -q - (ds / n) * i];
}

export class Sight {
  private readonly top: Int32Array; // height of what stands in a cell, metres, by [r, q + shift]
  private readonly columns: number;
  private readonly shift: number;

  constructor(
    private readonly map: HexMap,
    private readonly airHeightM: number,
  ) {
    this.shift = Math.floor(map.height / 2);
    this.columns = map.width + this.shift;
    this.top = new Int32Array(this.columns * map.height).fill(VOID_TOP_M);
    for (let cell = 0; cell < map.size; cell++) {
      if (map.level[cell] < 0) continue;
      const [q, r] = cubeOf(map, cell);
      const tree = map.bits[cell] & CONCEALED ? 1 : 0;
      this.top[r * this.columns + q + this.shift] = (map.level[cell] + tree) * map.gradeM;
    }
  }

  /** Whether the line between two cells is clear; either end may fly. */
  clear(a: number, b: number, aFlies: boolean, bFlies: boolean): boolean {
    let [aq, ar] = cubeOf(this.map, a);
    let [bq, br] = cubeOf(this.map, b);
    let aM = this.eye(a, aFlies);
    let bM = this.eye(b, bFlies);
    if (br < ar || (br === ar && bq < aq)) {
      [aq, ar, bq, br] = [bq, br, aq, ar];
      [aM, bM] = [bM, aM];
    }
    if (aM > bM) aM += this.map.gradeM;
    else if (bM > aM) bM += this.map.gradeM;
    return this.above(aq, ar, bq - aq, br - ar, aM, bM, false) || this.above(aq, ar, bq - aq, br - ar, aM, bM, true);
  }

  private eye(cell: number, flies: boolean): number {
    return this.map.level[cell] * this.map.gradeM + (flies ? this.airHeightM : 0);
  }

  private above(q: number, r: number, dq: number, dr: number, aM: number, bM: number, up: boolean): boolean {
    const n = Math.max(Math.abs(dq), Math.abs(dr), Math.abs(dq + dr));
    for (let i = 1; i < n; i++) {
      const [sq, sr] = sample(dq, dr, i, up);
      if (this.top[(r + sr) * this.columns + q + sq + this.shift] * n > aM * (n - i) + bM * i) return false;
    }
    return true;
  }

  /** The cells of the line between two cells, both ends too; -1 where it leaves the map. */
  cells(a: number, b: number): number[] {
    const [aq, ar] = cubeOf(this.map, a);
    const [bq, br] = cubeOf(this.map, b);
    const n = Math.max(Math.abs(bq - aq), Math.abs(br - ar), Math.abs(bq + br - aq - ar));
    return Array.from({ length: n + 1 }, (_, i) => {
      const [q, r] = n === 0 ? [0, 0] : sample(bq - aq, br - ar, i, false);
      return cellOf(this.map, aq + q, ar + r);
    });
  }

  /** The cells within a distance that are in line of sight of a cell: for each whether it is. */
  field(cell: number, reach: number, flies: boolean, targetFlies = false): Map<number, boolean> {
    const found = new Map<number, boolean>();
    for (const other of cellsWithin(this.map, cell, reach)) {
      found.set(other, this.clear(cell, other, flies, targetFlies));
    }
    return found;
  }
}
