#pragma once

#include <cstddef>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// Returns the balls round the cells of an octree over a solid: the textbook's sphere tree (Liu,
/// Noborio & Arimoto 1988; Hubbard, ACM TOG 15 (1996) 179-210), a baseline for the others.
///
/// The root is the smallest cube about the centre of the mesh's box that contains it.  A cell
/// counts if it meets the solid: a triangle touches it or, if none does, its centre lies inside.
/// Cells that no triangle touches are not split.  The others are split into those of their eight
/// parts that count: the largest first and, among those of one size, first the one whose ball
/// sticks out of the solid most.  A split that would make more than `count` cells is skipped, so at
/// most six are missing at the end; and no cell is split more than 20 times.  Each ball is the
/// smallest round its cell, so together they contain the solid, and much space outside it.
///
/// Set-up only.  Deterministic.
/// @param mesh   closed, as SolidOf leaves it; `query` is over it.
/// @param count  at least 1.
std::vector<Sphere> OctreeBalls(const TriangleMesh& mesh, const MeshQuery& query,
                                std::size_t count);

}  // namespace palpate
