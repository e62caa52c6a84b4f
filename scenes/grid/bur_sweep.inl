// The search of bur_sweep.cpp, compiled there once for each instruction set.  That gives a Four, a
// number of each of four points; Root, of all four; and Are, whether something holds for all.

inline Four Min(Four a, Four b) {
  return a < b ? a : b;
}
inline Four Max(Four a, Four b) {
  return a > b ? a : b;
}

struct Points {
  Four x, y, z;
};

struct Far {
  Four distance, slope;  ///< and how that changes along the way
};

/// To a bur that has gone a share t of its way.
inline Far To(const SweptCurve& bur, const Points& p, Four t) {
  const Four x = p.x - t * bur.step[0], y = p.y - t * bur.step[1], z = p.z - t * bur.step[2];
  const Four rho = Root(x * x + y * y);
  // Within the curve the nearest piece is the least deep; outside, the nearest point of any.
  Four inner = All(bur.count == 1 ? 0.0 : -1e300), rho_normal = All(1.0), z_normal = All(0.0);
  Four rho_away = rho - bur.rho[0], z_away = z - bur.z[0];
  Four nearest = rho_away * rho_away + z_away * z_away;
  for (int n = 0; n + 1 < bur.count; ++n) {
    const Four r = rho - bur.rho[n], h = z - bur.z[n];
    const Four above = r * bur.rho_normal[n] + h * bur.z_normal[n];
    const auto is_less_deep = above > inner;
    inner = is_less_deep ? above : inner;
    rho_normal = is_less_deep ? All(bur.rho_normal[n]) : rho_normal;
    z_normal = is_less_deep ? All(bur.z_normal[n]) : z_normal;
    // The curve is convex: the nearest point lies on a piece that faces this one.
    const double rho_along = bur.rho[n + 1] - bur.rho[n], z_along = bur.z[n + 1] - bur.z[n];
    const Four along = (r * rho_along + h * z_along) * bur.inverse_squared[n];
    const Four share = Min(Max(along, All(0.0)), All(1.0));
    const Four rho_gap = r - share * rho_along, z_gap = h - share * z_along;
    const Four squared = rho_gap * rho_gap + z_gap * z_gap;
    const auto is_nearer = (above >= 0.0) & (squared < nearest);
    nearest = is_nearer ? squared : nearest;
    rho_away = is_nearer ? rho_gap : rho_away;
    z_away = is_nearer ? z_gap : z_away;
  }
  const Four outer = Root(nearest);
  const auto is_outside = inner >= 0.0;
  const auto is_away = is_outside & (outer > 0.0);
  const Four per = 1.0 / (is_away ? outer : All(1.0));
  const Four outward = (is_away ? rho_away * per : rho_normal) / (rho > 0.0 ? rho : All(1e300));
  return {(is_outside ? outer : inner) - bur.rounding,
          -(outward * (x * bur.step[0] + y * bur.step[1]) +
            (is_away ? z_away * per : z_normal) * bur.step[2])};
}

/// A ball sweeps a capsule: of its axis a point sees the place it is beside, or an end.
inline Four ToCapsule(const SweptCurve& bur, const Points& p) {
  const Four z = p.z - bur.z[0];
  const Four along = p.x * bur.step[0] + p.y * bur.step[1] + z * bur.step[2];
  const Four t = Min(Max(along * bur.inverse_step_squared, All(0.0)), All(1.0));
  const Four dx = p.x - t * bur.step[0], dy = p.y - t * bur.step[1], dz = z - t * bur.step[2];
  return Root(dx * dx + dy * dy + dz * dz) - bur.rounding;
}

inline Four ToWay(const SweptCurve& bur, const Points& p, Four within) {
  if (bur.count == 1) return ToCapsule(bur, p);
  // The end first: before a bur that goes ahead, most points are nearest to that.
  Four from = All(0.0), to = All(1.0);
  const Far end = To(bur, p, to);
  const Four beyond = end.distance - within;
  const auto is_far = (beyond > 0.0) & (beyond * beyond > bur.step_squared);
  if (Are(is_far | (end.slope <= 0.0) | (beyond > end.slope))) return end.distance;
  const Far begin = To(bur, p, from);
  const Four ends = Min(begin.distance, end.distance);
  if (Are((begin.slope >= 0.0) | (end.slope <= 0.0))) return ends;
  Four least = ends, low = begin.slope, high = end.slope;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Four rise = high - low;
    const Four t = from - (to - from) * low / (rise > 0.0 ? rise : All(1.0));
    const Four inside = Min(Max(t, All(0.0)), All(1.0));
    const Far there = To(bur, p, inside);
    const auto is_before = there.slope < 0.0;
    from = is_before ? inside : from;
    low = is_before ? there.slope : low;
    to = is_before ? to : inside;
    high = is_before ? high : there.slope;
    least = Min(least, there.distance);
  }
  return least;
}

inline Points PointsOf(const Vec3& first, const Vec3& apart, int n) {
  const Four at = Four{0.0, 1.0, 2.0, 3.0} + static_cast<double>(n);
  return {first.x() + at * apart.x(), first.y() + at * apart.y(), first.z() + at * apart.z()};
}

void Distances(const SweptCurve& bur, const Vec3& first, const Vec3& apart,
               const BurSweep::Row& within, BurSweep::Row& distance) {
  for (int n = 0; n < BurSweep::kRow; n += kFour) {
    Four least;
    std::memcpy(&least, &within[static_cast<std::size_t>(n)], sizeof least);
    const Four found = ToWay(bur, PointsOf(first, apart, n), least);
    std::memcpy(&distance[static_cast<std::size_t>(n)], &found, sizeof found);
  }
}

BurSweep::Raised Raise(const SweptCurve& bur, const Vec3& first, const Vec3& apart, float band,
                       float* phi) {
  const FourFloats clear = FourFloats{} + band;
  Four room = All(1e300);
  FourFloats rise{};
  for (int n = 0; n < BurSweep::kRow; n += kFour) {
    FourFloats before;
    std::memcpy(&before, phi + n, sizeof before);
    // Only a distance below -phi raises a point, and none what is clear.
    const Four was = __builtin_convertvector(before, Four);
    const Four within = was < double{band} ? -was : All(-1e300);
    const Four distance = ToWay(bur, PointsOf(first, apart, n), within);
    const FourFloats depth = __builtin_convertvector(-distance, FourFloats);
    FourFloats after = depth > before ? depth : before;
    after = after < clear ? after : clear;
    std::memcpy(phi + n, &after, sizeof after);
    rise = after - before > rise ? after - before : rise;
    const Four is = __builtin_convertvector(after, Four);
    room = Min(room, is < double{band} ? distance + is : All(1e300));
  }
  return {rise[0] > 0.0f || rise[1] > 0.0f || rise[2] > 0.0f || rise[3] > 0.0f,
          std::min(std::min(room[0], room[1]), std::min(room[2], room[3]))};
}
