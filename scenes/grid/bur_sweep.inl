// The search of bur_sweep.cpp, which compiles it once for each instruction set.  It defines before:
// Eight, a number for each point of a row; Root, the square roots; and Are, whether a condition
// holds for all points.

inline Eight All(float v) {
  return Eight{} + v;
}
inline Eight Min(Eight a, Eight b) {
  return a < b ? a : b;
}
inline Eight Max(Eight a, Eight b) {
  return a > b ? a : b;
}

struct Points {
  Eight x, y, z;
};

struct Far {
  Eight distance, slope;  ///< `slope`: d distance / dt
};

/// Returns the distance to a bur that has gone a share t of its way.
inline Far To(const SweptCurve& bur, const Points& p, Eight t) {
  const Eight x = p.x - t * bur.step[0], y = p.y - t * bur.step[1], z = p.z - t * bur.step[2];
  const Eight rho = Root(x * x + y * y);
  // Inside the curve, the nearest segment is the one with the least depth; outside, take the
  // nearest point of all segments.
  Eight inner = All(bur.count == 1 ? 0.0f : -kHuge), rho_normal = All(1.0f), z_normal = All(0.0f);
  Eight rho_away = rho - bur.rho[0], z_away = z - bur.z[0];
  Eight nearest = rho_away * rho_away + z_away * z_away;
  for (int n = 0; n + 1 < bur.count; ++n) {
    const Eight r = rho - bur.rho[n], h = z - bur.z[n];
    const Eight above = r * bur.rho_normal[n] + h * bur.z_normal[n];
    const auto is_less_deep = above > inner;
    inner = is_less_deep ? above : inner;
    rho_normal = is_less_deep ? All(bur.rho_normal[n]) : rho_normal;
    z_normal = is_less_deep ? All(bur.z_normal[n]) : z_normal;
    // The curve is convex, so the nearest point lies on a segment that faces this one.
    const float rho_along = bur.rho[n + 1] - bur.rho[n], z_along = bur.z[n + 1] - bur.z[n];
    const Eight along = (r * rho_along + h * z_along) * bur.inverse_squared[n];
    const Eight share = Min(Max(along, All(0.0f)), All(1.0f));
    const Eight rho_gap = r - share * rho_along, z_gap = h - share * z_along;
    const Eight squared = rho_gap * rho_gap + z_gap * z_gap;
    const auto is_nearer = (above >= 0.0f) & (squared < nearest);
    nearest = is_nearer ? squared : nearest;
    rho_away = is_nearer ? rho_gap : rho_away;
    z_away = is_nearer ? z_gap : z_away;
  }
  const Eight outer = Root(nearest);
  const auto is_outside = inner >= 0.0f;
  const auto is_away = is_outside & (outer > 0.0f);
  const Eight per = 1.0f / (is_away ? outer : All(1.0f));
  const Eight outward = (is_away ? rho_away * per : rho_normal) / (rho > 0.0f ? rho : All(kHuge));
  return {(is_outside ? outer : inner) - bur.rounding,
          -(outward * (x * bur.step[0] + y * bur.step[1]) +
            (is_away ? z_away * per : z_normal) * bur.step[2])};
}

/// Returns the distance to the capsule that a ball sweeps: the distance to the nearest point of its
/// axis, less the radius.
inline Eight ToCapsule(const SweptCurve& bur, const Points& p) {
  const Eight z = p.z - bur.z[0];
  const Eight along = p.x * bur.step[0] + p.y * bur.step[1] + z * bur.step[2];
  const Eight t = Min(Max(along * bur.inverse_step_squared, All(0.0f)), All(1.0f));
  const Eight dx = p.x - t * bur.step[0], dy = p.y - t * bur.step[1], dz = z - t * bur.step[2];
  return Root(dx * dx + dy * dy + dz * dz) - bur.rounding;
}

inline Eight ToWay(const SweptCurve& bur, const Points& p, Eight within) {
  if (bur.count == 1) return ToCapsule(bur, p);
  // Try the end first: most points in front of an advancing bur are nearest to it.
  Eight from = All(0.0f), to = All(1.0f);
  const Far end = To(bur, p, to);
  const Eight beyond = end.distance - within;
  const auto is_far = (beyond > 0.0f) & (beyond * beyond > bur.step_squared);
  const auto is_last = (end.slope <= 0.0f) | (beyond > end.slope);
  // Inside a bore, the bur may on its way come nearer to the other side.
  if (Are(bur.hollow ? is_far : is_far | is_last)) return end.distance;
  const Far begin = To(bur, p, from);
  const Eight ends = Min(begin.distance, end.distance);
  const auto is_between = (begin.slope < 0.0f) & (end.slope > 0.0f);
  if (Are(is_between == 0)) return ends;
  Eight least = ends, low = begin.slope, high = end.slope;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Eight rise = high - low;
    const Eight t = from - (to - from) * low / (rise > 0.0f ? rise : All(1.0f));
    const Eight inside = Min(Max(t, All(0.0f)), All(1.0f));
    const Far there = To(bur, p, inside);
    const auto is_before = there.slope < 0.0f;
    from = is_before ? inside : from;
    low = is_before ? there.slope : low;
    to = is_before ? to : inside;
    high = is_before ? high : there.slope;
    least = is_between ? Min(least, there.distance) : least;
  }
  return least;
}

inline Points PointsOf(const Vec3& first, const Vec3& apart) {
  const Eight at{0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  const auto along = [&](int a) {
    return static_cast<float>(first[a]) + at * static_cast<float>(apart[a]);
  };
  return {along(0), along(1), along(2)};
}

void Distances(const SweptCurve& bur, const Vec3& first, const Vec3& apart, float within,
               BurSweep::Row& distance) {
  const Eight found = ToWay(bur, PointsOf(first, apart), All(within));
  std::memcpy(distance.data(), &found, sizeof found);
}

BurSweep::Raised Raise(const SweptCurve& bur, const Vec3& first, const Vec3& apart, float band,
                       float* phi) {
  const Eight clear = All(band);
  Eight before;
  std::memcpy(&before, phi, sizeof before);
  // Only a distance below -phi raises a point; a point at the band (clear) cannot rise.
  const Eight distance = ToWay(bur, PointsOf(first, apart), before < clear ? -before : -kHuge);
  const Eight after = Min(Max(before, -distance), clear);
  std::memcpy(phi, &after, sizeof after);
  const Eight room = after < clear ? distance + after : All(kHuge);
  float least = room[0];
  for (int n = 1; n < BurSweep::kRow; ++n) least = std::min(least, room[n]);
  return {!Are(after <= before), least};
}
