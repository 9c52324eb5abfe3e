// The lowest layer. It is drawn anew when a zoom or a pan has ended; meanwhile the old picture is moved and scaled.

import type { Camera } from "./camera";
import {
  CONCEALED, CORNERS, type HexMap, PASSABLE, PAVED, type Point, ROW, SIDE_OF, SLUSHY, cellName, centre, neighbour, onMap,
} from "./hex";
import { type Palette, shaded } from "./palette";

const MARGIN = 0.2; // of the view, drawn around it
const DIRECTIONS = [2, 3, 4]; // SE, E, NE: every pair of neighbours once
export const PATH_CELLS = 48; // cells in one path
const MAX_CLIMB = 5; // levels that a vehicle can climb

export class Terrain {
  private picture: HTMLCanvasElement | null = null;
  private drawn = { x: 0, y: 0, scale: 0, width: 0, height: 0 }; // the camera of the picture
  private readonly colours: Int16Array; // brightness of a cell, in hundredths
  private readonly highest: number;

  constructor(private readonly map: HexMap) {
    this.highest = Math.max(1, ...map.level);
    this.colours = new Int16Array(map.size);
    for (let cell = 0; cell < map.size; cell++) this.colours[cell] = Math.round(this.light(cell) * 100);
  }

  /** Brightness by the slope: light comes from the north-west. */
  private light(cell: number): number {
    const { map } = this;
    if (map.level[cell] < 0) return 1;
    const rise = (direction: number) => {
      const beside = neighbour(map, cell, direction);
      return beside < 0 ? 0 : map.level[beside] - map.level[cell];
    };
    const slope = rise(2) + rise(3) - rise(5) - rise(0);
    return 1 + Math.max(-0.1, Math.min(0.035, slope * 0.014));
  }

  forget(): void {
    this.picture = null;
  }

  /** Whether the picture is one of this zoom and has all of the view. */
  fits(camera: Camera): boolean {
    const d = this.drawn;
    if (!this.picture || d.scale !== camera.scale) return false;
    const x = Math.abs(camera.x - d.x) * d.scale + camera.width / 2;
    const y = Math.abs(camera.y - d.y) * d.scale + camera.height / 2;
    return x <= d.width / 2 && y <= d.height / 2;
  }

  blit(ctx: CanvasRenderingContext2D, camera: Camera, ratio: number): void {
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
    if (!this.picture) return;
    const d = this.drawn;
    const zoom = camera.scale / d.scale;
    const left = camera.width / 2 + (d.x - camera.x) * camera.scale - (d.width / 2) * zoom;
    const top = camera.height / 2 + (d.y - camera.y) * camera.scale - (d.height / 2) * zoom;
    ctx.drawImage(this.picture, left * ratio, top * ratio, d.width * zoom * ratio, d.height * zoom * ratio);
  }

  draw(camera: Camera, ratio: number, palette: Palette): void {
    const width = Math.ceil(camera.width * (1 + 2 * MARGIN));
    const height = Math.ceil(camera.height * (1 + 2 * MARGIN));
    this.drawn = { x: camera.x, y: camera.y, scale: camera.scale, width, height };
    this.picture ??= document.createElement("canvas");
    this.picture.width = width * ratio;
    this.picture.height = height * ratio;
    const ctx = this.picture.getContext("2d");
    if (!ctx) return;
    const s = camera.scale * ratio;
    ctx.setTransform(s, 0, 0, s, (width / 2) * ratio - camera.x * s, (height / 2) * ratio - camera.y * s);
    const cells = this.inView(camera, width, height);
    this.fill(ctx, cells, palette, camera.scale);
    this.edges(ctx, cells, palette);
    this.roads(ctx, cells, palette);
    if (camera.scale >= 13) this.glyphs(ctx, cells, palette);
    if (camera.scale >= 40) this.names(ctx, cells, palette);
  }

  private inView(camera: Camera, width: number, height: number): number[] {
    const { map } = this;
    const half = { x: width / camera.scale / 2 + 1, y: height / camera.scale / 2 + 1 };
    const [left, right] = [Math.floor(camera.x - half.x), Math.ceil(camera.x + half.x)];
    const [top, bottom] = [Math.floor((camera.y - half.y) / ROW), Math.ceil((camera.y + half.y) / ROW)];
    const found: number[] = [];
    for (let y = Math.max(0, top - 1); y < Math.min(map.height, bottom + 1); y++) {
      for (let x = Math.max(0, left - 1); x < Math.min(map.width, right + 1); x++) {
        if (map.level[y * map.width + x] >= 0) found.push(y * map.width + x);
      }
    }
    return found;
  }

  private colour(cell: number, palette: Palette): string {
    const { bits, level } = this.map;
    if (!(bits[cell] & PASSABLE)) return bits[cell] & CONCEALED ? palette.forest : palette.lake;
    const built = bits[cell] & PAVED && bits[cell] & CONCEALED;
    const last = palette.ground.length - 1;
    const ground = palette.ground[Math.round((level[cell] / Math.max(this.highest, 6)) * last)];
    const base = bits[cell] & SLUSHY ? palette.marsh : bits[cell] & CONCEALED && !built ? palette.forest : ground;
    return shaded(base, this.colours[cell] / 100);
  }

  private fill(ctx: CanvasRenderingContext2D, cells: number[], palette: Palette, scale: number): void {
    const groups = new Map<string, number[]>();
    for (const cell of cells) {
      const colour = this.colour(cell, palette);
      const group = groups.get(colour);
      if (group) group.push(cell);
      else groups.set(colour, [cell]);
    }
    ctx.lineJoin = "round";
    ctx.lineWidth = 0.06; // closes the seams between cells
    for (const [colour, group] of groups) {
      ctx.fillStyle = colour;
      ctx.strokeStyle = colour;
      this.outlines(ctx, group, () => {
        ctx.fill();
        ctx.stroke();
      });
    }
    if (scale < 9) return;
    ctx.strokeStyle = palette.grid;
    ctx.lineWidth = 1 / scale;
    this.outlines(ctx, cells, () => ctx.stroke());
  }

  /** Short paths: one of all cells takes ten times as long. */
  private outlines(ctx: CanvasRenderingContext2D, cells: number[], draw: () => void): void {
    for (let first = 0; first < cells.length; first += PATH_CELLS) {
      ctx.beginPath();
      for (const cell of cells.slice(first, first + PATH_CELLS)) trace(ctx, centre(this.map, cell));
      draw();
    }
  }

  private edges(ctx: CanvasRenderingContext2D, cells: number[], palette: Palette): void {
    const { map } = this;
    const shores = new Path2D();
    const cliffs = new Path2D();
    for (const cell of cells) {
      const place = centre(map, cell);
      for (const direction of DIRECTIONS) {
        const beside = neighbour(map, cell, direction);
        if (beside < 0) continue;
        const wet = !(map.bits[cell] & PASSABLE) !== !(map.bits[beside] & PASSABLE);
        const steep = Math.abs(map.level[cell] - map.level[beside]) > MAX_CLIMB;
        if (!wet && !steep) continue;
        const [a, b] = SIDE_OF[direction];
        const path = wet ? shores : cliffs;
        path.moveTo(place.x + CORNERS[a].x, place.y + CORNERS[a].y);
        path.lineTo(place.x + CORNERS[b].x, place.y + CORNERS[b].y);
      }
    }
    ctx.lineCap = "round";
    ctx.lineWidth = 0.12;
    ctx.strokeStyle = palette.shore;
    ctx.stroke(shores);
    ctx.lineWidth = 0.18;
    ctx.strokeStyle = palette.cliff;
    ctx.stroke(cliffs);
  }

  private roads(ctx: CanvasRenderingContext2D, cells: number[], palette: Palette): void {
    const { map } = this;
    const path = new Path2D();
    for (const cell of cells) {
      if (!(map.bits[cell] & PAVED)) continue;
      const place = centre(map, cell);
      for (const direction of DIRECTIONS) {
        const beside = neighbour(map, cell, direction);
        if (!onMap(map, beside) || !(map.bits[beside] & PAVED)) continue;
        const next = centre(map, beside);
        path.moveTo(place.x, place.y);
        path.lineTo(next.x, next.y);
      }
    }
    ctx.lineCap = "round";
    for (const [colour, width] of [[palette.roadEdge, 0.34], [palette.road, 0.22]] as const) {
      ctx.strokeStyle = colour;
      ctx.lineWidth = width;
      ctx.stroke(path);
    }
  }

  private glyphs(ctx: CanvasRenderingContext2D, cells: number[], palette: Palette): void {
    const trees = new Path2D();
    const rushes = new Path2D();
    const houses = new Path2D();
    for (const cell of cells) {
      const { x, y } = centre(this.map, cell);
      const bits = this.map.bits[cell];
      if (bits & CONCEALED && bits & PAVED) {
        for (const [dx, dy] of [[-0.24, -0.22], [0.2, -0.24], [-0.2, 0.2], [0.24, 0.22]]) houses.rect(x + dx - 0.07, y + dy - 0.07, 0.14, 0.14);
      } else if (bits & CONCEALED) {
        for (const [dx, dy] of [[-0.2, 0.02], [0.18, -0.1], [0.04, 0.26]]) {
          trees.moveTo(x + dx - 0.11, y + dy + 0.08);
          trees.lineTo(x + dx, y + dy - 0.14);
          trees.lineTo(x + dx + 0.11, y + dy + 0.08);
        }
      } else if (bits & SLUSHY) {
        for (const [dx, dy] of [[-0.2, -0.12], [0.08, 0.02], [-0.12, 0.2]]) {
          rushes.moveTo(x + dx, y + dy);
          rushes.lineTo(x + dx + 0.2, y + dy);
        }
      }
    }
    ctx.fillStyle = palette.tree;
    ctx.fill(trees);
    ctx.fillStyle = palette.house;
    ctx.fill(houses);
    ctx.strokeStyle = palette.rush;
    ctx.lineWidth = 0.05;
    ctx.stroke(rushes);
  }

  private names(ctx: CanvasRenderingContext2D, cells: number[], palette: Palette): void {
    ctx.fillStyle = palette.soft;
    ctx.globalAlpha = 0.8;
    ctx.font = "0.19px system-ui, sans-serif";
    ctx.textAlign = "center";
    for (const cell of cells) {
      const { x, y } = centre(this.map, cell);
      ctx.fillText(cellName(this.map, cell), x, y + 0.48);
    }
    ctx.globalAlpha = 1;
  }
}

export function trace(path: CanvasPath, place: Point, size = 1): void {
  path.moveTo(place.x + CORNERS[0].x * size, place.y + CORNERS[0].y * size);
  for (let k = 1; k < 6; k++) path.lineTo(place.x + CORNERS[k].x * size, place.y + CORNERS[k].y * size);
  path.closePath();
}
