#pragma once

#include <string>
#include <utility>
#include <vector>

#include "client/course/local_text.h"
#include "client/replayer/hand_path.h"
#include "client/replayer/score/score_plot.h"

namespace palpate {

/// The comparison of a trainee's trial with the expert's.
struct Score {
  double expert_s = 0.0, trainee_s = 0.0;  ///< of the trials
  // After alignment in time (dynamic time warping by position).
  double path_mean_mm = 0.0, path_max_mm = 0.0;
  double frechet_mm = 0.0;  ///< discrete Frechet distance of the paths
  double turn_mean_deg = 0.0;
  double force_rms_N = 0.0;  ///< of the difference of the force magnitudes
  double expert_peak_N = 0.0, trainee_peak_N = 0.0;
  double expert_contact_s = 0.0, trainee_contact_s = 0.0;

  // Over the expert's time, for plots.
  std::vector<double> time_s, distance_mm, expert_force_N, trainee_force_N;
  std::vector<Vec3> expert_m, trainee_m;  ///< positions of the hands, in W
};

/// Compares two trials (TrialIn).  Each is thinned to at most 3000 points, evenly in time.
Score ScorePath(const HandPath& expert, const HandPath& trainee);

/// A trainee's trial, compared with the expert's.
struct Trial {
  std::string name;
  Score score;
  std::vector<LocalText> incomplete = {};  ///< why it does not count; empty: it does
};
/// Returns the score's numbers with their member names.
std::vector<std::pair<const char*, double>> NumbersOf(const Score& score);
/// Returns the plots of distance and forces of all trials over the expert's time, their
/// common axis.
std::vector<ScorePlot> PlotsOf(const std::vector<Trial>& trials);

}  // namespace palpate
