#pragma once

#include <string>
#include <vector>

namespace palpate::bench {

/// A cutting force measured at a steady feed.
struct FeedForce {
  std::string material;
  double area = 0.0;   ///< of the bur's front, projected along the feed [m^2]
  double share = 1.0;  ///< integral of (n . d)^2 over that of n . d: flat front 1, ball 2/3
  double feed = 0.0;   ///< [m/s]
  double force = 0.0;  ///< [N]
};

/// The law F = A (p_0 + share kappa u), fitted to a material's points by least squares.
struct FittedLaw {
  std::string material;
  double pressure = 0.0, viscosity = 0.0;  ///< p_0 [Pa], kappa [Pa s/m], both >= 0
  double residual = 0.0;                   ///< root mean square [N]
};
/// Fits the law for each material, in order of first appearance.  Throws Error if a material has a
/// single feed, which does not determine both constants.
std::vector<FittedLaw> FitLaw(const std::vector<FeedForce>& points);

/// Reads rows of material,area_mm2,share,feed_mm_per_s,force_N; skips the first row and those that
/// begin with #.  Throws Error, which names the row.
std::vector<FeedForce> ReadFeedForces(const std::string& file);

/// `palpate-bench cut --fit`: prints the result of FitLaw and each point's residual.
void RunCutFit(const std::string& file, const std::string& json);

}  // namespace palpate::bench
