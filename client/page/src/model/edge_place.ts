/// The place of an arrow that points to something outside the picture.
export interface EdgePlace {
  readonly x: number; // [pixels] from the left
  readonly y: number; // from the top
  readonly angle: number; // clockwise from the right [rad]
}

/// A part of the picture, over its whole width [pixels].
export interface Room {
  readonly width: number;
  readonly top: number;
  readonly height: number;
}

/// @param at      the point in the camera's frame: x to the right, y up, -z forward [m]
/// @param tan     tangent of half the vertical field of view
/// @param room    the part of the picture that nothing covers, in whose middle the view's is [pixels]
/// @param height  height of the whole picture [pixels]
/// @param inset   distance from the room's edges: half of the arrow [pixels]
/// Returns undefined if the point is in the room.
export function edgePlace(
  at: readonly [number, number, number],
  tan: number,
  room: Room,
  height: number,
  inset: number,
): EdgePlace | undefined {
  const perTan = (0.5 * height) / tan;
  const [x, y, z] = at;
  // Offset from the middle of the view.  A point behind the camera is projected to its own side.
  const forward = Math.max(-z, 1e-9 * Math.hypot(x, y, z));
  const right = (perTan * x) / forward;
  const down = (-perTan * y) / forward;
  const [halfX, halfY] = [0.5 * room.width, 0.5 * room.height];
  if (z < 0 && Math.abs(right) <= halfX && Math.abs(down) <= halfY) return undefined;
  const share = Math.min(
    (halfX - inset) / Math.max(1e-9, Math.abs(right)),
    (halfY - inset) / Math.max(1e-9, Math.abs(down)),
    1,
  );
  return {
    x: halfX + share * right,
    y: room.top + halfY + share * down,
    angle: Math.atan2(down, right),
  };
}
