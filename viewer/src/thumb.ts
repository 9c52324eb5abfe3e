// Small pictures of how games ended: the terrain once a map, then points and pieces.

import { Camera } from "./camera";
import type { EntryDoc } from "./contents";
import { type HexMap, centre, extent } from "./hex";
import type { Palette } from "./palette";
import type { Camp, SetupDoc } from "./story";
import { Terrain } from "./terrain";
import { outline } from "./tokens";

const POINT = 6; // half the width of a control point, in pixels
const TOKEN = 5;

export class Thumbs {
  private readonly grounds = new Map<string, { terrain: Terrain; camera: Camera }>();

  draw(canvas: HTMLCanvasElement, entry: EntryDoc, setup: SetupDoc, map: HexMap, palette: Palette, ratio: number): void {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const ctx = canvas.getContext("2d");
    if (!ctx) return;
    const { terrain, camera } = this.ground(entry.map, map, [width, height], palette, ratio);
    terrain.blit(ctx, camera, ratio);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.lineWidth = 1.4;
    ctx.strokeStyle = "#ffffff";
    for (const [k, [, cell]] of setup.points.entries()) {
      const { x, y } = camera.toScreen(centre(map, cell));
      ctx.beginPath();
      for (const [dx, dy] of [[0, -1], [1, 0], [0, 1], [-1, 0]]) ctx.lineTo(x + dx * POINT * 1.35, y + dy * POINT * 1.35);
      ctx.closePath();
      ctx.fillStyle = palette.camp[(entry.owners[k] ?? "green") as Camp | "green"];
      ctx.fill();
      ctx.stroke();
    }
    for (const [piece, cell] of entry.tokens) {
      const camp = setup.roster[piece][0].split(":")[0] as Camp;
      outline(ctx, camp, camera.toScreen(centre(map, cell)), TOKEN);
      ctx.fillStyle = palette.camp[camp];
      ctx.fill();
      ctx.stroke();
    }
  }

  private ground(key: string, map: HexMap, [width, height]: [number, number], palette: Palette, ratio: number) {
    const name = [key, width, height, palette.dark, ratio].join(" ");
    let found = this.grounds.get(name);
    if (!found) {
      const camera = new Camera(extent(map));
      camera.resize(width, height);
      camera.fit();
      found = { terrain: new Terrain(map), camera };
      found.terrain.draw(camera, ratio, palette);
      this.grounds.set(name, found);
    }
    return found;
  }
}
