// What a plan looks like on the map: the ways that are planned, the way under the pointer, shots, the mortar's cells, the cursor.

import type { Camera } from "../camera";
import { type HexMap, type Point, centre } from "../hex";
import { arrow, drawCell, drawPath, paths, ring, stripe, withMap } from "../marks";
import { type Palette, fade } from "../palette";
import type { Overlay, Stage } from "../stage";
import { trace } from "../terrain";
import { plate, tokenSize } from "../tokens";

type Ctx = CanvasRenderingContext2D;

const TEXT_PX = 12;
const LINE_PX = 17;
const PLATES = [[0, -1], [0, 1], [-1, -1], [1, -1], [-1, 1], [1, 1]]; // where a plate may be: left or right, above or below
const NEAR = 1.6; // cells: an end that needs no label of its own

export interface PlannedWay {
  from: Point; // in cells of the map
  cells: number[];
  note: string; // on its end: when it arrives
  picked: boolean;
}

export interface PlannedShot {
  from: Point;
  to: Point;
  note: string;
  picked: boolean;
}

export interface Preview {
  from: Point;
  cells: number[];
  lines: string[]; // what is said of it, at its end
  eyes: Point[]; // enemies that would see the piece there
  end: number; // cell
}

export interface Drawn {
  map: HexMap;
  palette: Palette;
  colour: string; // of the camp
  ways: PlannedWay[];
  shots: PlannedShot[];
  preview: Preview | null;
  cursor: number; // -1 none
  mortar: MortarPaths | null;
}

export interface MortarPaths {
  key: string;
  byClass: Path2D[][]; // 0, 1, 2
  hatch: Path2D[]; // of class 0
}

/** The cells that a mortar reaches, by correction class; made once for a layer. */
export function mortarPaths(map: HexMap, key: string, cells: [number, number][]): MortarPaths {
  const outline = (path: Path2D, place: Point) => trace(path, place, 0.98);
  const of = (wanted: number) => cells.filter(([, one]) => one === wanted).map(([cell]) => cell);
  return { key, byClass: [0, 1, 2].map((one) => paths(map, of(one), outline)), hatch: paths(map, of(0), stripe) };
}

export const MORTAR_COLOURS = ["rgba(70,74,90,0.28)", "rgba(255,206,48,0.42)", "rgba(222,60,8,0.78)"];

function drawMortar(ctx: Ctx, layer: MortarPaths, camera: Camera): void {
  withMap(ctx, camera, () => {
    layer.byClass.forEach((found, k) => {
      ctx.fillStyle = MORTAR_COLOURS[k];
      for (const path of found) ctx.fill(path);
    });
    ctx.lineWidth = 0.05;
    ctx.strokeStyle = "rgba(255,255,255,0.42)";
    for (const path of layer.hatch) ctx.stroke(path);
  });
}

function drawShot(ctx: Ctx, shot: PlannedShot, camera: Camera, drawn: Drawn): void {
  const [from, to] = [camera.toScreen(shot.from), camera.toScreen(shot.to)];
  ctx.setLineDash([9, 5]);
  arrow(ctx, from, to, fade("#ffffff", 0.85), 5);
  arrow(ctx, from, to, drawn.colour, shot.picked ? 3 : 2);
  ctx.setLineDash([]);
  ring(ctx, to, tokenSize(camera) + 5, drawn.colour, 2.4);
}

function drawPreview(ctx: Ctx, preview: Preview, camera: Camera, drawn: Drawn): void {
  drawPath(ctx, drawn.map, preview.from, preview.cells, camera, drawn.palette.ink);
  const end = camera.toScreen(centre(drawn.map, preview.end));
  for (const eye of preview.eyes) {
    const from = camera.toScreen(eye);
    for (const [width, style] of [[3.6, fade("#ffffff", 0.8)], [1.8, drawn.palette.warn]] as const) {
      ctx.beginPath();
      ctx.moveTo(from.x, from.y);
      ctx.lineTo(end.x, end.y);
      ctx.lineWidth = width;
      ctx.strokeStyle = style;
      ctx.setLineDash([2, 6]);
      ctx.lineCap = "round";
      ctx.stroke();
    }
  }
  ctx.setLineDash([]);
}

function drawCursor(ctx: Ctx, drawn: Drawn, camera: Camera): void {
  drawCell(ctx, drawn.map, drawn.cursor, camera, drawn.palette);
  const at = camera.toScreen(centre(drawn.map, drawn.cursor));
  const size = Math.max(12, camera.scale * 0.75);
  ring(ctx, at, size + 1.5, fade("#ffffff", 0.9), 4);
  ring(ctx, at, size, drawn.palette.ink, 2);
}

/** Lines of text on one plate, kept on the screen, where it hides the fewest tokens. */
function labels(ctx: Ctx, lines: string[], at: Point, stage: Stage, palette: Palette): void {
  if (lines.length === 0) return;
  ctx.font = `600 ${TEXT_PX}px system-ui, -apple-system, "Segoe UI", sans-serif`;
  const width = Math.max(...lines.map((line) => ctx.measureText(line).width)) + 16;
  const height = lines.length * LINE_PX + 6;
  const { camera } = stage;
  const places = PLATES.map(([x, y]) => ({
    left: Math.max(4, Math.min(camera.width - width - 4, at.x - width / 2 + (x * width) / 2)),
    top: Math.max(4, Math.min(camera.height - height - 4, y < 0 ? at.y - height - 14 : at.y + 26)),
  }));
  const hides = (place: { left: number; top: number }) => stage.tokensUnder(place.left, place.top, width, height);
  const { left, top } = places.reduce((best, place) => (hides(place) < hides(best) ? place : best));
  ctx.beginPath();
  ctx.roundRect(left, top, width, height, 6);
  ctx.fillStyle = palette.plate;
  ctx.fill();
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillStyle = palette.ink;
  lines.forEach((line, k) => ctx.fillText(line, left + width / 2, top + 3 + (k + 0.5) * LINE_PX));
}

export function overlayOf(drawn: Drawn): Overlay {
  const { palette } = drawn;
  return {
    ground(ctx: Ctx, { camera }: Stage): void {
      if (drawn.mortar) drawMortar(ctx, drawn.mortar, camera);
    },
    below(ctx: Ctx, { camera }: Stage): void {
      for (const way of drawn.ways) drawPath(ctx, drawn.map, way.from, way.cells, camera, way.picked ? drawn.colour : fade(drawn.colour, 0.6));
      if (drawn.preview) drawPreview(ctx, drawn.preview, camera, drawn);
      if (drawn.cursor >= 0) drawCursor(ctx, drawn, camera);
    },
    above(ctx: Ctx, stage: Stage): void {
      const { camera } = stage;
      for (const shot of drawn.shots) drawShot(ctx, shot, camera, drawn);
      for (const shot of drawn.shots) if (shot.note) labels(ctx, [shot.note], camera.toScreen(shot.to), stage, palette);
      for (const way of drawn.ways) {
        const last = way.cells[way.cells.length - 1];
        if (last === undefined || !way.note || last === drawn.preview?.end) continue;
        const end = centre(drawn.map, last);
        if (Math.hypot(end.x - way.from.x, end.y - way.from.y) < NEAR) continue;
        const at = camera.toScreen(end);
        plate(ctx, way.note, { x: at.x, y: at.y + 15 }, 11, palette);
      }
      if (drawn.preview) labels(ctx, drawn.preview.lines, camera.toScreen(centre(drawn.map, drawn.preview.end)), stage, palette);
    },
  };
}
