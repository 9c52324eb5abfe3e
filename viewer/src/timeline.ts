// The score curve is the track: both margins, the marks of what happened by shape, the playhead, and a loop.

import type { Entry, LuckCurve } from "./log";
import { fade, type Palette } from "./palette";
import { CAMPS, type Camp, type Changes } from "./story";
import { outline } from "./tokens";

const LANE = 15; // height of a camp's lane of marks
const LEFT = 44;
const RIGHT = 12;
const SHOWN = new Set(["hit", "dead", "point", "sight", "refused", "round"]);
const NAMES: Record<string, string> = {
  miss: "shot", hit: "shot with loss", dead: "death", point: "capture", sight: "first sight", refused: "refused order", round: "mortar",
};

type Curves = Partial<Record<Camp, Changes<number>>>;

export class Timeline {
  loop: [number, number] | null = null;
  hover = -1;
  minds: { camp: Camp; ticks: number[] } | null = null; // when the picked piece changed its mind
  private back = document.createElement("canvas");
  private key = "";

  private curves: Curves = {};
  private beside: Curves = {}; // of the game that this one is compared with
  private entries: Entry[] = [];
  private last = 0;
  private gameTicks = 1;
  private parting = -1; // tick at which the two part; -1 none

  private width = 0; // of the canvas, CSS pixels: to ask for it while texts change takes its time
  private height = 0;

  constructor(readonly canvas: HTMLCanvasElement) {
    const measure = () => ([this.width, this.height] = [canvas.clientWidth, canvas.clientHeight]);
    new ResizeObserver(measure).observe(canvas);
  }

  show(curves: Curves, entries: Entry[], last: number, gameTicks: number, beside: Curves, parting: number): void {
    Object.assign(this, { curves, entries, last, gameTicks, beside, parting, key: "" });
  }

  x(tick: number): number {
    return LEFT + (tick / Math.max(1, this.gameTicks)) * (this.width - LEFT - RIGHT);
  }

  tickAt(x: number): number {
    const share = (x - LEFT) / (this.width - LEFT - RIGHT);
    return Math.max(0, Math.min(this.last, Math.round(share * this.gameTicks)));
  }

  /** Names of what happened near a place on the track. */
  near(tick: number): Entry | null {
    const reach = (6 / Math.max(1, this.width)) * this.gameTicks;
    const close = this.entries.filter((one) => (SHOWN.has(one.shape) || one.shape === "miss") && Math.abs(one.tick - tick) <= reach);
    const weight = (one: Entry) => ["point", "dead", "hit", "sight", "round", "refused", "miss"].indexOf(one.shape) * 1000 + Math.abs(one.tick - tick);
    return close.sort((a, b) => weight(a) - weight(b))[0] ?? null;
  }

  draw(time: number, palette: Palette, ratio: number, muted: boolean): void {
    const { canvas } = this;
    if (this.width === 0) [this.width, this.height] = [canvas.clientWidth, canvas.clientHeight]; // at the first frame
    const { width, height } = this;
    const key = [width, height, ratio, palette.dark, muted, this.loop?.join()].join(" ");
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    if (key !== this.key) {
      this.key = key;
      this.drawBack(width, height, palette, ratio, muted);
    }
    const ctx = canvas.getContext("2d");
    if (!ctx) return;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    ctx.drawImage(this.back, 0, 0);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    const x = this.x(time);
    ctx.fillStyle = fade(palette.dark ? "#000000" : "#ffffff", 0.45);
    ctx.fillRect(x, 0, this.x(this.gameTicks) - x, height - 14);
    if (this.minds && !muted) {
      const y = height - 14 - 2 * LANE + (this.minds.camp === "blue" ? LANE : 0) - 1;
      for (const tick of this.minds.ticks) wedge(ctx, this.x(tick), y, palette.warn);
    }
    if (this.hover >= 0) line(ctx, this.x(this.hover), 0, height - 14, palette.soft, 1);
    line(ctx, x, 0, height - 14, palette.ink, 2);
    ctx.beginPath();
    ctx.moveTo(x - 7, 0);
    ctx.lineTo(x + 7, 0);
    ctx.lineTo(x, 9);
    ctx.closePath();
    ctx.fillStyle = palette.ink;
    ctx.fill();
  }

  private drawBack(width: number, height: number, palette: Palette, ratio: number, muted: boolean): void {
    this.back.width = this.canvas.width;
    this.back.height = this.canvas.height;
    const ctx = this.back.getContext("2d");
    if (!ctx) return;
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const bottom = height - 14 - 2 * LANE - 2;
    const values = CAMPS.flatMap((camp) => [this.curves, this.beside].flatMap((curves) => (curves[camp] ?? []).filter((_, k) => k % 2 === 1))) as number[];
    const [low, high] = [Math.min(0, ...values) - 8, Math.max(0, ...values) + 8];
    const y = (value: number) => 6 + ((high - value) / (high - low)) * (bottom - 10);
    this.axes(ctx, width, height, y, [low, high], palette);
    if (this.loop) {
      ctx.fillStyle = fade(palette.warn, 0.22);
      ctx.fillRect(this.x(this.loop[0]), 0, this.x(this.loop[1]) - this.x(this.loop[0]), height - 14);
    }
    for (const camp of CAMPS) this.curve(ctx, this.beside[camp], camp, y, fade(palette.camp[camp], 0.5), 1.2);
    for (const camp of CAMPS) this.curve(ctx, this.curves[camp], camp, y, palette.text[camp], 2.2);
    if (this.parting >= 0) this.part(ctx, bottom, palette);
    CAMPS.forEach((camp, k) => this.lane(ctx, camp, bottom + 2 + k * LANE, palette, muted));
  }

  private axes(ctx: CanvasRenderingContext2D, width: number, height: number, y: (v: number) => number, [low, high]: [number, number], palette: Palette): void {
    ctx.font = "11px system-ui, sans-serif";
    ctx.textBaseline = "middle";
    ctx.fillStyle = palette.soft;
    const room = Math.abs(y(0) - y(1)); // pixels a point
    const step = [50, 100, 200, 400].find((one) => one * room >= 13) ?? 500;
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      line(ctx, LEFT, y(value), 0, value === 0 ? palette.soft : palette.line, 1, width - RIGHT);
      ctx.textAlign = "right";
      ctx.fillText(value > 0 ? `+${value}` : `${value}`.replace("-", "−"), LEFT - 6, y(value));
    }
    ctx.textAlign = "center";
    const every = [1, 5, 15, 60, 150, 300, 600, 1500, 3000].find((one) => (one / this.gameTicks) * width >= 70) ?? 6000;
    for (let tick = 0; tick <= this.gameTicks; tick += every) {
      ctx.textAlign = this.x(tick) > width - 24 ? "right" : "center";
      ctx.fillText(String(tick), this.x(tick) + (ctx.textAlign === "right" ? RIGHT : 0), height - 6);
    }
  }

  /** Where two games part. */
  private part(ctx: CanvasRenderingContext2D, bottom: number, palette: Palette): void {
    const x = this.x(this.parting);
    line(ctx, x, 0, bottom, palette.warn, 2);
    ctx.textAlign = "left";
    ctx.font = "600 11px system-ui, sans-serif";
    ctx.fillStyle = palette.ink;
    ctx.fillText("they part", x + 9, 9);
  }

  private curve(ctx: CanvasRenderingContext2D, list: Changes<number> | undefined, camp: Camp, y: (v: number) => number, colour: string, width: number): void {
    if (!list) return;
    ctx.beginPath();
    for (let k = 0; k < list.length; k += 2) {
      const [tick, value] = [list[k], list[k + 1]];
      if (k === 0) ctx.moveTo(this.x(tick), y(value));
      else {
        ctx.lineTo(this.x(tick), y(list[k - 1]));
        ctx.lineTo(this.x(tick), y(value));
      }
    }
    ctx.lineTo(this.x(this.last), y(list[list.length - 1]));
    ctx.lineJoin = "round";
    ctx.lineWidth = width;
    ctx.setLineDash(camp === "blue" ? [7, 3] : []);
    ctx.strokeStyle = colour;
    ctx.stroke();
    ctx.setLineDash([]);
  }

  private lane(ctx: CanvasRenderingContext2D, camp: Camp, top: number, palette: Palette, muted: boolean): void {
    const middle = top + LANE / 2;
    outline(ctx, camp, { x: LEFT - 14, y: middle }, 5);
    ctx.fillStyle = palette.camp[camp];
    ctx.fill();
    line(ctx, LEFT, middle, 0, palette.line, 1, this.x(this.gameTicks));
    if (muted) return;
    for (const one of this.entries) {
      if (one.camp !== camp) continue;
      if (one.shape === "miss") dot(ctx, this.x(one.tick), middle, 1.4, palette.soft);
      else if (one.shape === "choice") line(ctx, this.x(one.tick), top + 1, top + 4, palette.soft, 1);
    }
    for (const one of this.entries) {
      if (one.camp === camp && SHOWN.has(one.shape)) mark(ctx, one, { x: this.x(one.tick), y: middle }, palette);
    }
  }
}

function line(ctx: CanvasRenderingContext2D, x: number, y: number, bottom: number, colour: string, width: number, right?: number): void {
  ctx.beginPath();
  ctx.moveTo(x, y);
  if (right === undefined) ctx.lineTo(x, bottom);
  else ctx.lineTo(right, y);
  ctx.lineWidth = width;
  ctx.strokeStyle = colour;
  ctx.stroke();
}

function wedge(ctx: CanvasRenderingContext2D, x: number, y: number, colour: string): void {
  ctx.beginPath();
  ctx.moveTo(x - 3.5, y);
  ctx.lineTo(x + 3.5, y);
  ctx.lineTo(x, y + 5);
  ctx.closePath();
  ctx.fillStyle = colour;
  ctx.fill();
}

function dot(ctx: CanvasRenderingContext2D, x: number, y: number, size: number, colour: string): void {
  ctx.beginPath();
  ctx.arc(x, y, size, 0, 7);
  ctx.fillStyle = colour;
  ctx.fill();
}

/** A shape for each kind of event; colour only says the camp again. */
export function mark(ctx: CanvasRenderingContext2D, one: Pick<Entry, "shape" | "camp">, at: { x: number; y: number }, palette: Palette): void {
  const colour = palette.text[one.camp];
  const { x, y } = at;
  ctx.lineWidth = 1.8;
  ctx.strokeStyle = colour;
  ctx.fillStyle = colour;
  ctx.beginPath();
  if (one.shape === "hit") {
    ctx.moveTo(x, y - 5);
    ctx.lineTo(x + 4.4, y + 3.6);
    ctx.lineTo(x - 4.4, y + 3.6);
    ctx.closePath();
    ctx.fill();
  } else if (one.shape === "dead") {
    ctx.moveTo(x - 4.2, y - 4.2);
    ctx.lineTo(x + 4.2, y + 4.2);
    ctx.moveTo(x + 4.2, y - 4.2);
    ctx.lineTo(x - 4.2, y + 4.2);
    ctx.lineWidth = 2.6;
    ctx.stroke();
  } else if (one.shape === "point") {
    ctx.moveTo(x, y - 6.4);
    ctx.lineTo(x + 6.4, y);
    ctx.lineTo(x, y + 6.4);
    ctx.lineTo(x - 6.4, y);
    ctx.closePath();
    ctx.fill();
    ctx.strokeStyle = palette.paper;
    ctx.lineWidth = 1;
    ctx.stroke();
    dot(ctx, x, y, 1.8, palette.paper);
  } else if (one.shape === "sight") {
    ctx.arc(x, y, 3.6, 0, 7);
    ctx.stroke();
    dot(ctx, x, y, 1.2, colour);
  } else if (one.shape === "round") {
    ctx.arc(x, y, 3, Math.PI, 0);
    ctx.stroke();
  } else if (one.shape === "refused") {
    ctx.rect(x - 2.6, y - 2.6, 5.2, 5.2);
    ctx.lineWidth = 1.2;
    ctx.stroke();
  } else {
    dot(ctx, x, y, 1.8, colour);
  }
}

export function markName(shape: string): string {
  return NAMES[shape] ?? shape;
}

/** Luck of both camps: what their shots brought beyond what was to be expected, with one standard deviation around nothing. */
export function drawLuck(canvas: HTMLCanvasElement, curves: Partial<Record<Camp, LuckCurve>>, time: number, last: number, palette: Palette, ratio: number): void {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const ctx = canvas.getContext("2d");
  if (!ctx) return;
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, width, height);
  const x = (tick: number) => 4 + (tick / Math.max(1, last)) * (width - 8);
  const most = Math.max(5, ...CAMPS.flatMap((camp) => [...(curves[camp]?.sum.map(Math.abs) ?? []), ...(curves[camp]?.sigma ?? [])]));
  const y = (value: number) => height / 2 - (value / most) * (height / 2 - 4);
  for (const camp of CAMPS) {
    const curve = curves[camp];
    if (!curve) continue;
    step(ctx, curve.ticks, curve.sigma, x, y, last);
    const upper = curve.sigma.map((value) => -value);
    for (let k = upper.length - 1; k >= 0; k--) {
      ctx.lineTo(x(curve.ticks[k + 1] ?? last), y(upper[k]));
      ctx.lineTo(x(curve.ticks[k]), y(upper[k]));
    }
    ctx.closePath();
    ctx.fillStyle = fade(palette.camp[camp], 0.1);
    ctx.fill();
  }
  line(ctx, 4, y(0), 0, palette.soft, 1, width - 4);
  for (const camp of CAMPS) {
    const curve = curves[camp];
    if (!curve) continue;
    step(ctx, curve.ticks, curve.sum, x, y, last);
    ctx.lineWidth = 2;
    ctx.setLineDash(camp === "blue" ? [6, 3] : []);
    ctx.strokeStyle = palette.text[camp];
    ctx.stroke();
    ctx.setLineDash([]);
  }
  line(ctx, x(time), 2, height - 2, palette.ink, 1.5);
}

function step(ctx: CanvasRenderingContext2D, ticks: number[], values: number[], x: (t: number) => number, y: (v: number) => number, last: number): void {
  ctx.beginPath();
  ticks.forEach((tick, k) => {
    if (k) ctx.lineTo(x(tick), y(values[k - 1]));
    else ctx.moveTo(x(tick), y(values[k]));
    ctx.lineTo(x(tick), y(values[k]));
  });
  ctx.lineTo(x(last), y(values[values.length - 1]));
}
