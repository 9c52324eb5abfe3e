// Colours of the canvas, light and dark. Camps differ by shape and letter as well, so that no colour has to be told apart.

import type { Camp } from "./story";

export interface Palette {
  dark: boolean;
  ground: string[]; // from low to high
  forest: string;
  tree: string;
  marsh: string;
  rush: string;
  lake: string;
  shore: string;
  road: string;
  roadEdge: string;
  house: string;
  cliff: string;
  grid: string;
  fog: [number, number, number, number];
  ink: string;
  plate: string;
  rim: string;
  camp: Record<Camp | "green", string>;
  text: Record<Camp | "green", string>; // of the same camps, where it is a text on the page
  warn: string;
  paper: string;
  line: string;
  soft: string;
}

const LIGHT: Palette = {
  dark: false,
  ground: ["#ebeee0", "#e5e7d4", "#dddcc5", "#d3ceb5", "#c8bfa5", "#bcaf98", "#b0a28f"],
  forest: "#adcb9e",
  tree: "#98ba8c",
  marsh: "#cbe3dd",
  rush: "#8fb8ac",
  lake: "#abd0ea",
  shore: "#7fadd0",
  road: "#fffaf0",
  roadEdge: "#a79a83",
  house: "#a08f80",
  cliff: "#8a7660",
  grid: "rgba(40,50,40,0.075)",
  fog: [44, 52, 70, 104],
  ink: "#1d232b",
  plate: "rgba(255,255,255,0.88)",
  rim: "#ffffff",
  camp: { red: "#c22513", blue: "#1b58b8", green: "#6f756c" },
  text: { red: "#b3200f", blue: "#174d9f", green: "#555b52" },
  warn: "#e89a08",
  paper: "#ffffff",
  line: "#d7dce2",
  soft: "#5b6470",
};

const DARK: Palette = {
  dark: true,
  ground: ["#343b38", "#383e38", "#3e4138", "#444339", "#4b463b", "#514a3d", "#574e41"],
  forest: "#2c4634",
  tree: "#34513a",
  marsh: "#2f4a49",
  rush: "#4b716d",
  lake: "#26435c",
  shore: "#3f6a8e",
  road: "#bdb59f",
  roadEdge: "#23241f",
  house: "#817464",
  cliff: "#1f1b16",
  grid: "rgba(255,255,255,0.06)",
  fog: [4, 7, 13, 150],
  ink: "#eef1f5",
  plate: "rgba(18,22,28,0.86)",
  rim: "#ffffff",
  camp: { red: "#e8543f", blue: "#2f74dd", green: "#9aa297" },
  text: { red: "#ff9485", blue: "#8fbcff", green: "#aab1a6" },
  warn: "#ffd05e",
  paper: "#171b21",
  line: "#333a44",
  soft: "#a3acb8",
};

export const BURST = "#ffc428"; // what was hit

export function paletteOf(dark: boolean): Palette {
  return dark ? DARK : LIGHT;
}

/** A colour with an alpha, from "#rrggbb". */
export function fade(colour: string, alpha: number): string {
  const number = Number.parseInt(colour.slice(1), 16);
  return `rgba(${number >> 16},${(number >> 8) & 255},${number & 255},${alpha})`;
}

/** A colour made lighter or darker; shade 1 leaves it. */
export function shaded(colour: string, shade: number): string {
  const number = Number.parseInt(colour.slice(1), 16);
  const parts = [number >> 16, (number >> 8) & 255, number & 255].map((part) => Math.min(255, Math.round(part * shade)));
  return `rgb(${parts.join(",")})`;
}
