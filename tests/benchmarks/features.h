#pragma once

#include <optional>
#include <string>

#include "scenes/scene.h"
#include "tests/benchmarks/commands.h"

namespace palpate::bench {

/// The options --contact and --friction, the same for every command.
struct FeatureOptions {
  // Empty: the scene's; for an experiment without a scene, surface and off.
  std::string contact = {};
  std::string friction = {};

  void AddTo(const CommandLine& command);
  /// None: the scene's.
  std::optional<ContactModel> contact_model() const;
  /// The features for an experiment without a scene.
  Features features() const;
  /// Overrides the scene's features with the options.  If friction is requested and the scene has
  /// no coefficients, its materials get those of chapter 2.5.6, 0.8 and 0.3.
  void ApplyTo(Scene& scene) const;
};

/// Return the names in options and JSON outputs.
const char* NameOf(ContactModel contact);
const char* NameOf(FrictionModel friction);

}  // namespace palpate::bench
