#pragma once

#include <string>

namespace palpate {

/// What is wrong with the springs k_t [N/m] and k_r [N m/rad] between hand and tool, for a tool
/// that reaches so far from its centroid [m], and the remedy; empty where they will do.
///
/// The step counts a rotation as rho = sqrt(k_r / k_t) times its angle, a length.  Where the tool
/// reaches beyond 1,000 rho, friction's penalty of 10^5 (server/physics/limits.h) times the square
/// of that, 10^11, comes too near to what doubles hold, 10^16.
std::string CouplingFault(double stiffness, double torsional_stiffness, double reach);

}  // namespace palpate
