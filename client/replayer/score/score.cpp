#include "client/replayer/score/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/math/rotation.h"

namespace palpate {
namespace {

constexpr std::size_t kMostPoints = 3000;

struct Track {
  std::vector<double> time_s;  // from 0
  std::vector<Vec3> p;
  std::vector<Quat> q;
  std::vector<double> force_N;
  double duration_s = 0.0, peak_N = 0.0, contact_s = 0.0;
};

/// Returns the thinned trial.
Track TrackOf(const HandPath& trial) {
  Track track;
  track.duration_s = trial.duration_s();
  for (std::size_t i = 0; i < trial.size(); ++i) {
    const double force = trial.force_N[i].norm();
    track.peak_N = std::max(track.peak_N, force);
    if (i > 0 && trial.touches(i)) track.contact_s += trial.time_s[i] - trial.time_s[i - 1];
  }
  const std::size_t points = std::min(kMostPoints, trial.size());
  std::size_t at = 0;
  for (std::size_t k = 0; k < points; ++k) {
    const double t = track.duration_s * static_cast<double>(k) / static_cast<double>(points - 1);
    while (at + 1 < trial.size() && trial.time_s[at + 1] <= t) ++at;
    track.time_s.push_back(trial.time_s[at]);
    track.p.push_back(trial.X_WH[at].p);
    track.q.push_back(trial.X_WH[at].q);
    track.force_N.push_back(trial.force_N[at].norm());
  }
  return track;
}

/// Returns the monotone alignment with the least sum of distances, as pairs of points from first to
/// last (dynamic time warping: Sakoe & Chiba, IEEE ASSP 26 (1978) 43-49).
std::vector<std::pair<std::size_t, std::size_t>> Align(const Track& a, const Track& b) {
  const std::size_t n = a.p.size(), m = b.p.size();
  std::vector<double> before(m), now(m);
  // 0: from both, 1: from a's previous point, 2: from b's previous point.
  std::vector<std::uint8_t> came(n * m);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < m; ++j) {
      const double d = (a.p[i] - b.p[j]).norm();
      constexpr double kNone = std::numeric_limits<double>::infinity();
      const double both = i > 0 && j > 0 ? before[j - 1] : kNone;
      const double of_a = i > 0 ? before[j] : kNone;
      const double of_b = j > 0 ? now[j - 1] : kNone;
      double best = both;
      std::uint8_t from = 0;
      if (of_a < best) {
        best = of_a;
        from = 1;
      }
      if (of_b < best) {
        best = of_b;
        from = 2;
      }
      now[j] = d + (i == 0 && j == 0 ? 0.0 : best);
      came[i * m + j] = from;
    }
    std::swap(before, now);
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = n - 1, j = m - 1;;) {
    pairs.emplace_back(i, j);
    if (i == 0 && j == 0) break;
    const std::uint8_t from = came[i * m + j];
    if (from != 2) --i;
    if (from != 1) --j;
  }
  std::ranges::reverse(pairs);
  return pairs;
}

/// Returns the discrete Frechet distance (Eiter & Mannila, TU Wien report CD-TR 94/64, 1994).
double Frechet(const Track& a, const Track& b) {
  const std::size_t n = a.p.size(), m = b.p.size();
  std::vector<double> before(m), now(m);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < m; ++j) {
      const double d = (a.p[i] - b.p[j]).norm();
      double reach = std::numeric_limits<double>::infinity();
      if (i == 0 && j == 0) reach = d;
      if (i > 0) reach = std::min(reach, before[j]);
      if (j > 0) reach = std::min(reach, now[j - 1]);
      if (i > 0 && j > 0) reach = std::min(reach, before[j - 1]);
      now[j] = std::max(reach, d);
    }
    std::swap(before, now);
  }
  return before[m - 1];
}

}  // namespace

Score ScorePath(const HandPath& expert, const HandPath& trainee) {
  const Track a = TrackOf(expert), b = TrackOf(trainee);
  Score score;
  score.expert_s = a.duration_s;
  score.trainee_s = b.duration_s;
  score.expert_peak_N = a.peak_N;
  score.trainee_peak_N = b.peak_N;
  score.expert_contact_s = a.contact_s;
  score.trainee_contact_s = b.contact_s;
  score.frechet_mm = 1e3 * Frechet(a, b);
  const auto pairs = Align(a, b);
  double force2 = 0.0;
  std::size_t last = a.p.size();
  for (const auto& [i, j] : pairs) {
    const double distance = 1e3 * (a.p[i] - b.p[j]).norm();
    score.path_mean_mm += distance;
    score.path_max_mm = std::max(score.path_max_mm, distance);
    score.turn_mean_deg += RotationLog(a.q[i] * b.q[j].conjugate()).norm();
    force2 += (a.force_N[i] - b.force_N[j]) * (a.force_N[i] - b.force_N[j]);
    if (i == last) continue;  // the plots have one point for each point of the expert
    last = i;
    score.time_s.push_back(a.time_s[i]);
    score.distance_mm.push_back(distance);
    score.expert_force_N.push_back(a.force_N[i]);
    score.trainee_force_N.push_back(b.force_N[j]);
    score.expert_m.push_back(a.p[i]);
    score.trainee_m.push_back(b.p[j]);
  }
  const auto count = static_cast<double>(pairs.size());
  score.path_mean_mm /= count;
  score.turn_mean_deg *= 180.0 / std::numbers::pi / count;
  score.force_rms_N = std::sqrt(force2 / count);
  return score;
}

std::vector<std::pair<const char*, double>> NumbersOf(const Score& s) {
  return {{"expert_s", s.expert_s},
          {"trainee_s", s.trainee_s},
          {"path_mean_mm", s.path_mean_mm},
          {"path_max_mm", s.path_max_mm},
          {"frechet_mm", s.frechet_mm},
          {"turn_mean_deg", s.turn_mean_deg},
          {"force_rms_N", s.force_rms_N},
          {"expert_peak_N", s.expert_peak_N},
          {"trainee_peak_N", s.trainee_peak_N},
          {"expert_contact_s", s.expert_contact_s},
          {"trainee_contact_s", s.trainee_contact_s}};
}

std::vector<ScorePlot> PlotsOf(const std::vector<Trial>& trials) {
  const Score& first = trials.front().score;
  ScorePlot path{.title = "plot.distance",
                 .subtitle = "plot.aligned",
                 .x_title = "plot.time",
                 .y_title = "plot.distance_axis",
                 .lines = {{"expert", {0.0, first.time_s.back()}, {0.0, 0.0}}}};
  ScorePlot force{.title = "plot.force",
                  .subtitle = "plot.same",
                  .x_title = path.x_title,
                  .y_title = "plot.force_axis",
                  .lines = {{"expert", first.time_s, first.expert_force_N}}};
  for (const Trial& trial : trials) {
    path.lines.push_back({trial.name, trial.score.time_s, trial.score.distance_mm});
    force.lines.push_back({trial.name, trial.score.time_s, trial.score.trainee_force_N});
  }
  return {path, force};
}

}  // namespace palpate
