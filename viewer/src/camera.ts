// What part of the map is on the screen: a centre in cells, and how many pixels a cell has.

import type { Point } from "./hex";

export const MOST_SCALE = 96;

export class Camera {
  x = 0;
  y = 0;
  scale = 10; // CSS pixels a cell
  width = 1;
  height = 1;

  constructor(private extent: Point) {}

  resize(width: number, height: number): void {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
    this.keep();
  }

  get fitScale(): number {
    return Math.min(this.width / (this.extent.x + 1), this.height / (this.extent.y + 1));
  }

  toScreen(place: Point): Point {
    return { x: (place.x - this.x) * this.scale + this.width / 2, y: (place.y - this.y) * this.scale + this.height / 2 };
  }

  toMap(place: Point): Point {
    return { x: (place.x - this.width / 2) / this.scale + this.x, y: (place.y - this.height / 2) / this.scale + this.y };
  }

  /** All of the map. */
  fit(): void {
    this.scale = this.fitScale;
    this.x = this.extent.x / 2;
    this.y = this.extent.y / 2;
  }

  /** A part of the map, with room around it; above and below some pixels are left free. */
  show(places: Point[], room: number, [above, below] = [0, 0]): void {
    const xs = places.map((place) => place.x);
    const ys = places.map((place) => place.y);
    const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    this.x = (left + right) / 2;
    this.y = (top + bottom) / 2;
    this.scale = Math.min(this.width / (right - left + 2 * room), (this.height - above - below) / (bottom - top + 2 * room), 40);
    this.keepScale();
    this.y += (below - above) / 2 / this.scale;
    this.keep();
  }

  zoom(factor: number, around: Point): void {
    const before = this.toMap(around);
    this.scale *= factor;
    this.keepScale();
    const after = this.toMap(around);
    this.x += before.x - after.x;
    this.y += before.y - after.y;
    this.keep();
  }

  pan(dx: number, dy: number): void {
    this.x -= dx / this.scale;
    this.y -= dy / this.scale;
    this.keep();
  }

  private keepScale(): void {
    this.scale = Math.min(MOST_SCALE, Math.max(this.fitScale * 0.9, this.scale));
  }

  private keep(): void {
    this.keepScale();
    const half = { x: this.width / this.scale / 2, y: this.height / this.scale / 2 };
    this.x = kept(this.x, half.x, this.extent.x);
    this.y = kept(this.y, half.y, this.extent.y);
  }
}

function kept(value: number, half: number, size: number): number {
  const slack = 1.5;
  return half * 2 >= size + 2 * slack ? size / 2 : Math.min(size - half + slack, Math.max(half - slack, value));
}
