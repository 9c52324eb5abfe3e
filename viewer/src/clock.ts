// The clock of the page: it plays, jumps and steps, and asks for a frame only while something moves.

import { SPEEDS } from "./commands";
import { byId } from "./dom";

export const DECISION = 75;
const MOST_STEP_MS = 250; // that a slow frame lets pass

export abstract class Clock {
  time = 0;
  speed = 16;
  playing = false;
  private asked = 0; // number of the frame that was asked for
  private before = 0; // time of the last frame

  abstract get last(): number;
  abstract get loop(): [number, number] | null;
  abstract get isOpen(): boolean; // there is a game to play
  abstract get eventTicks(): number[];
  abstract get decisionTicks(): number[];
  abstract draw(now: number): void;
  abstract stopped(): void; // it stands at another tick
  abstract noteMoment(): void;

  ask(): void {
    if (!this.asked) this.asked = requestAnimationFrame((now) => this.tick(now));
  }

  private tick(now: number): void {
    this.asked = 0;
    if (this.playing) this.advance(Math.min(MOST_STEP_MS, now - this.before));
    this.before = now;
    this.draw(now);
    if (this.playing) this.ask();
  }

  private advance(ms: number): void {
    const end = this.loop?.[1] ?? this.last;
    this.time += (ms / 1000) * this.speed;
    if (this.time < end) return;
    if (this.loop) this.time = this.loop[0];
    else {
      this.time = end;
      this.play(false);
    }
  }

  /** It stands, and nobody is told. */
  halt(): void {
    this.showPlaying(false);
  }

  play(playing: boolean): void {
    if (!this.isOpen) return;
    if (playing && this.time >= this.last) this.time = 0;
    this.before = performance.now();
    this.showPlaying(playing);
    if (!playing) {
      this.time = Math.floor(this.time);
      this.stopped();
    }
    this.ask();
  }

  private showPlaying(playing: boolean): void {
    this.playing = playing;
    byId("play").classList.toggle("on", playing);
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  seek(tick: number): void {
    this.time = Math.max(0, Math.min(this.last, Math.floor(tick)));
    this.stopped();
    this.ask();
  }

  step(direction: 1 | -1): void {
    const now = Math.floor(this.time);
    const ticks = this.eventTicks;
    const next = direction > 0 ? ticks.find((tick) => tick > now) : ticks.filter((tick) => tick < now).pop();
    this.seek(next ?? (direction > 0 ? this.last : 0));
  }

  decide(): void {
    const now = Math.floor(this.time);
    const next = this.decisionTicks.filter((tick) => tick > now).sort((a, b) => a - b)[0];
    this.seek(next ?? (Math.floor(now / DECISION) + 1) * DECISION);
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.noteMoment();
    this.ask();
  }

  faster(by: 1 | -1): void {
    const k = SPEEDS.indexOf(this.speed) + by;
    this.setSpeed(SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, k))]);
  }
}
