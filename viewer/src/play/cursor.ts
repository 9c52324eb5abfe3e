// The cell cursor: arrows reach every cell. Up and down keep the column, so that two of them cancel each other.

import { type HexMap, onMap } from "../hex";

const FAR = 5; // cells, with shift

const STEPS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export function isStep(key: string): boolean {
  return key in STEPS;
}

/** The cell that a key leads to; at the edge of the map it stays. */
export function stepped(map: HexMap, cell: number, key: string, far: boolean): number {
  const [dx, dy] = STEPS[key];
  let here = cell;
  for (let k = 0; k < (far ? FAR : 1); k++) here = beside(map, here, dx, dy);
  return here;
}

function beside(map: HexMap, cell: number, dx: number, dy: number): number {
  const [x, y] = [(cell % map.width) + dx, Math.floor(cell / map.width) + dy];
  if (x < 0 || x >= map.width || y < 0 || y >= map.height) return cell;
  const found = y * map.width + x;
  if (onMap(map, found)) return found;
  return dy !== 0 && x > 0 && onMap(map, found - 1) ? found - 1 : cell; // odd rows are one cell shorter
}
