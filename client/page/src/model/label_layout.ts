/// Places labels so that each can be read: near their wanted place, apart from each other and from
/// what they must not hide.  All in pixels; equal inputs give equal places.
export interface Point {
  readonly x: number;
  readonly y: number;
}
export interface Circle extends Point {
  readonly radius: number;
}
export interface Box {
  readonly width: number;
  readonly height: number;
}

const kRounds = 60;
// share of the way back to the wanted place, in each round except the last ones
const kBack = 0.04;
const kSettle = 20;

export function layOut(
  wanted: readonly Point[],
  label: Box,
  keepClear: readonly Circle[],
  room: Box,
): Point[] {
  const places = wanted.map(({x, y}) => ({x, y}));
  const reach = 0.5 * Math.hypot(label.width, label.height);
  for (let round = 0; round < kRounds; round++) {
    places.forEach((place, i) => {
      if (round < kRounds - kSettle) {
        place.x += kBack * (wanted[i]!.x - place.x);
        place.y += kBack * (wanted[i]!.y - place.y);
      }
      for (const circle of keepClear) pushOff(place, circle, circle.radius + reach);
      for (let j = 0; j < i; j++) part(place, places[j]!, label);
      place.x = clamp(place.x, 0.5 * label.width, room.width - 0.5 * label.width);
      place.y = clamp(place.y, 0.5 * label.height, room.height - 0.5 * label.height);
    });
  }
  return places;
}

const clamp = (x: number, low: number, high: number): number => Math.min(high, Math.max(low, x));

function pushOff(place: {x: number; y: number}, from: Point, least: number): void {
  const dx = place.x - from.x;
  const dy = place.y - from.y;
  const distance = Math.hypot(dx, dy);
  if (distance >= least) return;
  const out = distance > 1e-6 ? least / distance : 0;
  place.x = from.x + (out > 0 ? out * dx : least);
  place.y = from.y + out * dy;
}

/// Each moves by half of the overlap, along its smaller extent.
function part(a: {x: number; y: number}, b: {x: number; y: number}, label: Box): void {
  const overX = label.width - Math.abs(a.x - b.x);
  const overY = label.height - Math.abs(a.y - b.y);
  if (overX <= 0 || overY <= 0) return;
  const along = overX < overY ? "x" : "y";
  const half = 0.5 * Math.min(overX, overY) * (a[along] < b[along] ? -1 : 1);
  a[along] += half;
  b[along] -= half;
}
