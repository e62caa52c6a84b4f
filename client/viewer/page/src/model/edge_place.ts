/// Where an arrow stands that points to what is out of the picture.
export interface EdgePlace {
  readonly x: number; // [pixels] from the left
  readonly y: number; // from the top
  readonly angle: number; // clockwise from the right [rad]
}

/// @param at      the point in the eye's frame: x to the right, y up, -z forward [m]
/// @param tan     tangent of half the field of view, up
/// @param room    of the picture, as far down as nothing covers it [pixels]
/// @param height  of the whole picture [pixels]
/// @param inset   from the room's edges: half of the arrow [pixels]
/// Nothing where the point is in the room.
export function edgePlace(
  at: readonly [number, number, number],
  tan: number,
  room: {readonly width: number; readonly height: number},
  height: number,
  inset: number,
): EdgePlace | undefined {
  const perTan = (0.5 * height) / tan;
  const [x, y, z] = at;
  // From the middle of the picture.  What is behind the eye lies on the side on which it is.
  const forward = Math.max(-z, 1e-9 * Math.hypot(x, y, z));
  const right = (perTan * x) / forward;
  const down = (-perTan * y) / forward;
  const middle = {x: 0.5 * room.width, y: 0.5 * height};
  const isIn =
    z < 0 && Math.abs(right) <= middle.x && down >= -middle.y && middle.y + down <= room.height;
  if (isIn) return undefined;
  const most = {
    right: middle.x - inset,
    up: middle.y - inset,
    down: room.height - inset - middle.y,
  };
  const share = Math.min(
    most.right / Math.max(1e-9, Math.abs(right)),
    (down < 0 ? most.up : most.down) / Math.max(1e-9, Math.abs(down)),
    1,
  );
  return {
    x: middle.x + share * right,
    y: middle.y + share * down,
    angle: Math.atan2(down, right),
  };
}
