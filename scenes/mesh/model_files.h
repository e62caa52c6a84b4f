#pragma once

#include <string>
#include <vector>

namespace palpate {

/// Returns the mesh file of a well-known model, "bunny", "dragon" or "buddha", from the first of
/// these folders that has it:
///   `models_dir` (--models), $PALPATE_MODELS, $PALPATE_MODELS_NPM,
///   models/node_modules of what comes with the programs (common/files/project_files.h),
///   build/models/node_modules of the working folder,
///   /usr/share/glmark2/models.
/// Throws Error with the places and how to get the model.
std::string FindModel(const std::string& name, const std::string& models_dir);

}  // namespace palpate
