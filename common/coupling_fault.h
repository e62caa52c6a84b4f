#pragma once

#include <string>

namespace palpate {

/// Returns what is wrong with the springs k_t [N/m] and k_r [N m/rad] between hand and tool, and
/// the remedy; empty if they are usable.
///
/// The step measures a rotation as a length: its angle times rho = sqrt(k_r / k_t).  Friction has a
/// penalty of 10^5 (server/physics/limits.h), which is multiplied by (reach / rho)^2.  For a reach
/// of more than 1,000 rho the product, 10^11, comes too close to the precision of doubles, 10^16.
/// @param reach  greatest distance of the tool's points from its centroid [m].
std::string CouplingFault(double stiffness, double torsional_stiffness, double reach);

}  // namespace palpate
