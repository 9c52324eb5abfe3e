// Texts on the map: each stands where it hides least of the pieces and of the other texts.

import type { Camera } from "./camera";
import type { Point } from "./hex";
import type { Palette } from "./palette";
import { type Token, plate, plateWidth } from "./tokens";

const SIZE = 12; // of the letters, pixels
const BARS = 3; // by which a token with its blood reaches lower than its middle says
const AGE = 16; // pixels that the age of a ghost has above it
const PLACES = [[0, -1], [0, 1.15], [1, 0], [-1, 0], [0.7, -0.8], [-0.7, -0.8], [0.7, 0.9], [-0.7, 0.9], [0, -2], [0, 2.2], [1, -2], [-1, -2], [1, 2.2], [-1, 2.2]];

interface Label {
  text: string;
  at: Point;
  half: Point; // half its width and height
}

export class Labels {
  private readonly found: Label[] = [];
  free: [number, number] = [0, 0]; // pixels above and below that lie under buttons

  clear(): void {
    this.found.length = 0;
  }

  /** A text beside a place that has a mark of some size. */
  add(ctx: CanvasRenderingContext2D, text: string, around: Point, size: number, tokens: Token[], camera: Camera): void {
    const half = { x: plateWidth(ctx, text, SIZE) / 2, y: SIZE * 0.72 };
    const places = PLACES.map(([x, y]) => ({ x: around.x + x * (size + 5 + half.x), y: around.y + y * (size + 13) }));
    const costs = places.map((at) => this.cost(at, half, tokens, camera));
    const best = places[costs.indexOf(Math.min(...costs))];
    this.found.push({ text, at: best, half });
  }

  /** How much of a text in a place hides pieces or other texts, or is outside. */
  private cost(at: Point, half: Point, tokens: Token[], camera: Camera): number {
    let sum = 0;
    for (const one of tokens) {
      const age = one.ghost ? AGE / 2 : 0;
      sum += shared(at, half, { x: one.at.x, y: one.at.y + BARS - age }, { x: one.size + 4, y: one.size + 4 + age });
    }
    for (const one of this.found) sum += 4 * shared(at, half, one.at, { x: one.half.x + 2, y: one.half.y + 2 });
    const [above, below] = this.free;
    const out = Math.max(0, half.x - at.x, at.x + half.x - camera.width) + Math.max(0, above + half.y - at.y, at.y + half.y - (camera.height - below));
    return sum + 100 * out;
  }

  draw(ctx: CanvasRenderingContext2D, palette: Palette): void {
    for (const { text, at } of this.found) plate(ctx, text, at, SIZE, palette);
  }
}

/** The area that two boxes share. */
function shared(a: Point, halfA: Point, b: Point, halfB: Point): number {
  const x = halfA.x + halfB.x - Math.abs(a.x - b.x);
  const y = halfA.y + halfB.y - Math.abs(a.y - b.y);
  return x > 0 && y > 0 ? x * y : 0;
}
