// Line of sight is the engine's, bit for bit. test/los.json is made by Python (tests/viewer/los_fixture.py);
// LOS_FIXTURE names a larger one.

import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { cellName, type MapDoc, readMap } from "../src/hex";
import { Sight } from "../src/los";

interface Fixture {
  air_height_m: number;
  reach: number;
  maps: { map: MapDoc; cells: number[]; seen: [string, string, string][] }[];
}

const path = process.env.LOS_FIXTURE ?? `${import.meta.dirname}/los.json`;
const fixture = JSON.parse(readFileSync(path, "utf8")) as Fixture;
const ENDS = [[false, false], [true, false], [true, true]] as const; // ground, one end in the air, both

/** A hash of a list of numbers, as Python makes it. */
function hash(cells: number[]): string {
  let value = 0x811c9dc5;
  for (const cell of cells) {
    for (const byte of [cell & 255, cell >> 8]) value = Math.imul(value ^ byte, 0x01000193) >>> 0;
  }
  return value.toString(16);
}

for (const { map: doc, cells, seen } of fixture.maps) {
  test(`sees what the engine sees on ${doc.name} ${doc.width}x${doc.height}`, () => {
    const map = readMap(doc);
    const sight = new Sight(map, fixture.air_height_m);
    cells.forEach((cell, k) => {
      ENDS.forEach(([flies, target], kind) => {
        const field = [...sight.field(cell, fixture.reach, flies, target)].filter(([, clear]) => clear);
        const found = field.map(([other]) => other).sort((a, b) => a - b);
        expect(hash(found), `${cellName(map, cell)}, kind ${kind}: ${found.length} cells`).toBe(seen[k][kind]);
      });
    });
  });
}
