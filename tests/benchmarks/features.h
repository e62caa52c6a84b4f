#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "scenes/scene.h"

namespace palpate::bench {

/// The names that command lines and JSON outputs use.
const char* NameOf(ContactModel contact);
const char* NameOf(FrictionModel friction);

/// The options --contact and --friction, the same for every command.  Empty: as the scene says.
struct FeatureOptions {
  std::string contact{};   ///< spheres, surface
  std::string friction{};  ///< off, chapter, coulomb

  void AddTo(CLI::App& command);
  /// Sets the features that are named.  Where friction is asked of a scene that names no
  /// coefficient, its materials get those of the chapter's 2.5.6, 0.8 and 0.3.
  void ApplyTo(Scene& scene) const;
  /// For what is no scene of the catalogue: spheres and no friction, unless named otherwise.
  Features features() const;
};

}  // namespace palpate::bench
