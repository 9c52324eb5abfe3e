import { expect, test } from "vitest";
import { BURST, type Palette, fade, paletteOf, shaded } from "../src/palette";
import { EYES, type Eyes, type Rgb, deltaE, over, rgbOf, seenBy } from "./colours";

// Least CIEDE2000 for usual eyes, without red cones and without green cones, light and dark. Shapes, letters and rims say the same again.
const CAMPS_APART = 20; // red, blue, nobody's; suppression on a piece; curves of a chart
const FROM_GROUND = 16; // a piece from any ground, in fog or not
const EVENTS_FROM_GROUND = 15; // suppression, bursts: both have a dark edge
const FROM_PAPER = 30; // curves, marks of the timeline, texts
const FROM_RIM = 22; // what stands still, a control point, from its white rim
const LATER = 0.45; // how much of the paper lies over what has not happened yet
const SHADES = [0.9, 1, 1.035]; // of the slopes: terrain.ts

const cases = [false, true].flatMap((dark) => (Object.keys(EYES) as Eyes[]).map((eyes) => [dark ? "dark" : "light", eyes, paletteOf(dark)] as const));

function apart(eyes: Eyes, a: Rgb, b: Rgb): number {
  return deltaE(seenBy(eyes, a), seenBy(eyes, b));
}

/** All that can lie below a piece: slopes, plants, water, roads; seen and in fog. */
function grounds(palette: Palette): Rgb[] {
  const { ground, forest, marsh, tree, rush, lake, road, fog } = palette;
  const bare = [...[...ground, forest, marsh].flatMap((colour) => SHADES.map((shade) => rgbOf(shaded(colour, shade)))), ...[tree, rush, lake, road].map((colour) => rgbOf(colour))];
  return bare.flatMap((colour) => [colour, over([fog[0], fog[1], fog[2]], fog[3] / 255, colour)]);
}

test("colour differences are those of the paper on CIEDE2000", () => {
  expect(deltaE([50, 2.6772, -79.7751], [50, 0, -82.7485])).toBeCloseTo(2.0425, 4);
  expect(deltaE([50, 2.49, -0.001], [50, -2.49, 0.0011])).toBeCloseTo(7.2195, 4);
  expect(deltaE([50, 2.5, 0], [73, 25, -18])).toBeCloseTo(27.1492, 4);
  expect(deltaE([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387])).toBeCloseTo(1.2644, 4);
});

test("a red and a green that usual eyes tell apart are alike without red or green cones", () => {
  const [red, green]: Rgb[] = [[170, 90, 60], [110, 110, 60]];
  expect(apart("usual", red, green)).toBeGreaterThan(CAMPS_APART);
  expect(apart("deuteranopia", red, green)).toBeLessThan(CAMPS_APART);
  expect(apart("usual", [0, 0, 0], [255, 255, 255])).toBeCloseTo(100, 1);
});

test.each(cases)("camps are told apart: %s, %s", (_, eyes, { camp, warn }) => {
  for (const [a, b] of [[camp.red, camp.blue], [camp.red, camp.green], [camp.blue, camp.green], [warn, camp.red], [warn, camp.blue]]) {
    expect(apart(eyes, rgbOf(a), rgbOf(b)), `${a} and ${b}`).toBeGreaterThan(CAMPS_APART);
  }
  expect(apart(eyes, rgbOf(camp.green), [255, 255, 255])).toBeGreaterThan(FROM_RIM);
});

test.each(cases)("pieces and events are told from all ground below them: %s, %s", (_, eyes, palette) => {
  for (const below of grounds(palette)) {
    for (const colour of [palette.camp.red, palette.camp.blue]) expect(apart(eyes, rgbOf(colour), below), `${colour} on ${below}`).toBeGreaterThan(FROM_GROUND);
    for (const colour of [palette.warn, BURST]) expect(apart(eyes, rgbOf(colour), below), `${colour} on ${below}`).toBeGreaterThan(EVENTS_FROM_GROUND);
  }
});

test.each(cases)("curves and marks of the timeline are told apart, and from the paper: %s, %s", (_, eyes, { text, camp, paper, warn }) => {
  const [page, red, blue] = [rgbOf(paper), rgbOf(text.red), rgbOf(text.blue)];
  const beside = [rgbOf(fade(camp.red, 0.5), page), rgbOf(fade(camp.blue, 0.5), page)]; // of the game beside
  const later = [over(page, LATER, red), over(page, LATER, blue)];
  for (const [a, b] of [[red, blue], beside, later]) expect(apart(eyes, a as Rgb, b as Rgb)).toBeGreaterThan(CAMPS_APART);
  for (const colour of [red, blue, rgbOf(warn)]) expect(apart(eyes, colour, page)).toBeGreaterThan(FROM_PAPER);
});
