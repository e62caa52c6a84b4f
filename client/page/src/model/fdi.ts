/// ISO 3950 (FDI) tooth numbers: the quadrant, then the position from the middle.
const kQuadrants = ["upper-right", "upper-left", "lower-left", "lower-right"] as const;
const kPlaces = [
  "central-incisor",
  "lateral-incisor",
  "canine",
  "first-premolar",
  "second-premolar",
  "first-molar",
  "second-molar",
  "third-molar",
] as const;

/// @param name  of a body, such as upper-left-canine.  Returns undefined if it is no tooth's.
export function fdiOf(name: string): string | undefined {
  const quadrant = kQuadrants.findIndex((of) => name.startsWith(`${of}-`));
  if (quadrant < 0) return undefined;
  const place = kPlaces.findIndex((of) => name === `${kQuadrants[quadrant]}-${of}`);
  return place < 0 ? undefined : `${quadrant + 1}${place + 1}`;
}
