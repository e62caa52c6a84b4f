#pragma once

#include <string>
#include <vector>

namespace palpate::bench {

/// A force that was measured at a steady feed.
struct FeedForce {
  std::string material;
  double area = 0.0;  ///< of the bur's front as the feed sees it [m^2]
  double share =
      1.0;  ///< integral of (n . d)^2 over that of n . d: 1 of a flat front, 2/3 of a ball
  double feed = 0.0;   ///< [m/s]
  double force = 0.0;  ///< [N]
};

/// The law, F = A (p_0 + share kappa u), that is nearest to a material's points by least squares.
struct FittedLaw {
  std::string material;
  double pressure = 0.0, viscosity = 0.0;  ///< p_0 [Pa], kappa [Pa s/m], both >= 0
  double residual = 0.0;                   ///< root of the mean square [N]
};
/// In the order in which materials come.  Throws Error where a material has a single feed, which
/// leaves open how its force is shared.
std::vector<FittedLaw> FitLaw(const std::vector<FeedForce>& points);

/// Rows of material,area_mm2,share,feed_mm_per_s,force_N; the first row and those that begin with #
/// are not read.  Throws Error that names the row.
std::vector<FeedForce> ReadFeedForces(const std::string& file);

/// `palpate-bench cut --fit`: prints what FitLaw finds, and each point's residual.
void RunCutFit(const std::string& file, const std::string& json);

}  // namespace palpate::bench
