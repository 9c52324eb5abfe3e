// Fog: a small picture of the whole map in which each dot belongs to one cell. What changes is a table of cells.
// A cell is clear where a vehicle that does not hide would be seen.

import type { Camera } from "./camera";
import { CONCEALED, type HexMap, apart, cellAt, extent } from "./hex";
import type { Sight } from "./los";
import type { Palette } from "./palette";
import type { Shown } from "./state";
import type { RulesDoc } from "./story";

const DOTS = 8; // a cell

export class Fog {
  private readonly picture = document.createElement("canvas");
  private readonly cells: Int32Array; // of every dot, -1 off the map
  private readonly dots: ImageData;
  private readonly views = new Map<string, number[]>(); // cells in sight, by kind and cell of the observer
  private clear: Uint8Array;
  private key = "";

  constructor(
    private readonly map: HexMap,
    private readonly sight: Sight,
    private readonly rules: RulesDoc,
  ) {
    const size = extent(map);
    this.picture.width = Math.ceil(size.x * DOTS);
    this.picture.height = Math.ceil(size.y * DOTS);
    this.dots = new ImageData(this.picture.width, this.picture.height);
    this.cells = new Int32Array(this.picture.width * this.picture.height);
    this.clear = new Uint8Array(map.size);
    for (let k = 0; k < this.cells.length; k++) {
      const place = { x: ((k % this.picture.width) + 0.5) / DOTS, y: (Math.floor(k / this.picture.width) + 0.5) / DOTS };
      this.cells[k] = cellAt(map, place);
    }
  }

  /** The cells that an observer has in sight. */
  inSight(kind: string, cell: number): number[] {
    const key = `${kind} ${cell}`;
    const known = this.views.get(key);
    if (known) return known;
    const reach = this.rules.kinds[kind].sight.tank;
    const cover = Math.max(1, Math.floor(reach / this.rules.concealed_sight_divisor));
    const found: number[] = [];
    for (const [other, seen] of this.sight.field(cell, reach, kind === "aerocraft")) {
      if (seen && (!(this.map.bits[other] & CONCEALED) || apart(this.map, cell, other) <= cover)) found.push(other);
    }
    this.views.set(key, found);
    return found;
  }

  /** Bring it up to the pieces of a camp; says whether anything changed. */
  look(own: Shown[], palette: Palette): boolean {
    const eyes = own.filter((one) => one.blood > 0 && one.carrier < 0);
    const key = `${palette.dark} ${eyes.map((one) => `${one.piece.kind}${one.cell}`).join()}`;
    if (key === this.key) return false;
    this.key = key;
    this.clear.fill(0);
    for (const one of eyes) for (const cell of this.inSight(one.piece.kind, one.cell)) this.clear[cell] = 1;
    this.paint(palette);
    return true;
  }

  isClear(cell: number): boolean {
    return this.clear[cell] === 1;
  }

  private paint(palette: Palette): void {
    const [r, g, b, a] = palette.fog;
    const fog = (a << 24) | (b << 16) | (g << 8) | r;
    const dots = new Uint32Array(this.dots.data.buffer);
    for (let k = 0; k < dots.length; k++) {
      const cell = this.cells[k];
      dots[k] = cell < 0 || this.clear[cell] ? 0 : fog;
    }
    this.picture.getContext("2d")?.putImageData(this.dots, 0, 0);
  }

  blit(ctx: CanvasRenderingContext2D, camera: Camera, ratio: number, shown: boolean): void {
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
    if (!shown) return;
    const corner = camera.toScreen({ x: 0, y: 0 });
    const zoom = (camera.scale * ratio) / DOTS;
    ctx.imageSmoothingQuality = "high";
    ctx.drawImage(this.picture, corner.x * ratio, corner.y * ratio, this.picture.width * zoom, this.picture.height * zoom);
  }
}
