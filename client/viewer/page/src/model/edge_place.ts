/// The place of an arrow that points to something outside the picture.
export interface EdgePlace {
  readonly x: number; // [pixels] from the left
  readonly y: number; // from the top
  readonly angle: number; // clockwise from the right [rad]
}

/// @param at      the point in the camera's frame: x to the right, y up, -z forward [m]
/// @param tan     tangent of half the vertical field of view
/// @param room    size of the picture, down to what covers its lower part [pixels]
/// @param height  height of the whole picture [pixels]
/// @param inset   distance from the room's edges: half of the arrow [pixels]
/// Returns undefined if the point is in the room.
export function edgePlace(
  at: readonly [number, number, number],
  tan: number,
  room: {readonly width: number; readonly height: number},
  height: number,
  inset: number,
): EdgePlace | undefined {
  const perTan = (0.5 * height) / tan;
  const [x, y, z] = at;
  // Offset from the middle of the picture.  A point behind the camera is projected to its own side.
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
