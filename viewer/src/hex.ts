// Geometry of the map: odd rows are shifted by half a cell and one cell shorter (docs/rules.md, section 1).
// A cell is the number y * width + x. One cell is 1 wide; north is up, y grows southwards.

export interface MapDoc {
  name: string;
  width: number;
  height: number;
  grade_m: number;
  terrain: string[];
  levels: string[];
}

export interface HexMap {
  name: string;
  width: number;
  height: number;
  gradeM: number;
  size: number;
  level: Int16Array; // of every cell; -1 off the map
  bits: Uint8Array; // PASSABLE and so on
}

export interface Point {
  x: number;
  y: number;
}

export const PASSABLE = 1;
export const PAVED = 2;
export const CONCEALED = 4;
export const SLUSHY = 8;
const SYMBOLS: Record<string, number> = { ".": 1, f: 5, m: 9, w: 13, "=": 3, b: 7, d: 11, e: 15, "~": 0, x: 2, "^": 4 };

export const ROW = Math.sqrt(3) / 2; // height of a row
export const RADIUS = 1 / Math.sqrt(3); // from the centre to a corner
export const STEPS: readonly (readonly [number, number])[] = [[-1, 0], [-1, 1], [0, 1], [1, 0], [1, -1], [0, -1]]; // W SW SE E NE NW
export const CORNERS: readonly Point[] = [0, 1, 2, 3, 4, 5].map((k) => {
  const angle = (Math.PI / 3) * k - Math.PI / 2; // N, NE, SE, S, SW, NW
  return { x: RADIUS * Math.cos(angle), y: RADIUS * Math.sin(angle) };
});
export const SIDE_OF: readonly (readonly [number, number])[] = [[5, 4], [4, 3], [3, 2], [2, 1], [1, 0], [0, 5]]; // its two corners, by direction

export function readMap(doc: MapDoc): HexMap {
  const size = doc.width * doc.height;
  const level = new Int16Array(size).fill(-1);
  const bits = new Uint8Array(size);
  for (let y = 0; y < doc.height; y++) {
    const numbers = doc.levels[y].split(" ");
    for (let x = 0; x < doc.width - (y & 1); x++) {
      level[y * doc.width + x] = Number(numbers[x]);
      bits[y * doc.width + x] = SYMBOLS[doc.terrain[y][x]];
    }
  }
  return { name: doc.name, width: doc.width, height: doc.height, gradeM: doc.grade_m, size, level, bits };
}

export function onMap(map: HexMap, cell: number): boolean {
  return cell >= 0 && cell < map.size && map.level[cell] >= 0;
}

export function centre(map: HexMap, cell: number): Point {
  const y = Math.floor(cell / map.width);
  return { x: (cell % map.width) + 0.5 + (y & 1) / 2, y: (y + 2 / 3) * ROW };
}

export function extent(map: HexMap): Point {
  return { x: map.width, y: (map.height + 1 / 3) * ROW };
}

/** Digits of the column, and of the row, in the names of a map's cells. */
export function nameDigits(map: HexMap): number {
  return Math.max(map.width, map.height) < 100 ? 2 : 3;
}

export function cellName(map: HexMap, cell: number): string {
  const y = Math.floor(cell / map.width);
  const digits = nameDigits(map);
  return String((cell % map.width) + 1).padStart(digits, "0") + String(y + 1).padStart(digits, "0");
}

/** Whether a word may be the name of a cell on some map. */
export const isCellName = (word: string): boolean => /^([0-9]{4}|[0-9]{6})$/.test(word);

export function parseCell(map: HexMap, name: string): number {
  const digits = nameDigits(map);
  if (!isCellName(name) || name.length !== 2 * digits) return -1;
  const x = Number(name.slice(0, digits)) - 1;
  const y = Number(name.slice(digits)) - 1;
  const cell = y * map.width + x;
  return x >= 0 && y >= 0 && x < map.width && onMap(map, cell) ? cell : -1;
}

export function cubeOf(map: HexMap, cell: number): [number, number] {
  const r = Math.floor(cell / map.width);
  return [(cell % map.width) - (r - (r & 1)) / 2, r];
}

export function cellOf(map: HexMap, q: number, r: number): number {
  const x = q + (r - (r & 1)) / 2;
  if (r < 0 || r >= map.height || x < 0 || x >= map.width) return -1;
  const cell = r * map.width + x;
  return map.level[cell] >= 0 ? cell : -1;
}

export function neighbour(map: HexMap, cell: number, direction: number): number {
  const [q, r] = cubeOf(map, cell);
  return cellOf(map, q + STEPS[direction][0], r + STEPS[direction][1]);
}

export function apart(map: HexMap, a: number, b: number): number {
  const [aq, ar] = cubeOf(map, a);
  const [bq, br] = cubeOf(map, b);
  return (Math.abs(aq - bq) + Math.abs(ar - br) + Math.abs(aq + ar - bq - br)) / 2;
}

/** The cell under a place, -1 off the map. */
export function cellAt(map: HexMap, place: Point): number {
  const r = place.y / ROW - 2 / 3;
  const q = place.x - 0.5 - r / 2;
  let rq = Math.round(q);
  let rr = Math.round(r);
  const rs = Math.round(-q - r);
  const dq = Math.abs(rq - q);
  const dr = Math.abs(rr - r);
  const ds = Math.abs(rs + q + r);
  if (dq > dr && dq > ds) rq = -rr - rs;
  else if (dr > ds) rr = -rq - rs;
  return cellOf(map, rq, rr);
}

/** All cells within a distance. */
export function cellsWithin(map: HexMap, cell: number, reach: number): number[] {
  const [q, r] = cubeOf(map, cell);
  const found: number[] = [];
  for (let dr = -reach; dr <= reach; dr++) {
    for (let dq = Math.max(-reach, -dr - reach); dq <= Math.min(reach, reach - dr); dq++) {
      const other = cellOf(map, q + dq, r + dr);
      if (other >= 0) found.push(other);
    }
  }
  return found;
}
