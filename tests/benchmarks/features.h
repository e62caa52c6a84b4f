#pragma once

#include <optional>
#include <string>

#include "scenes/scene.h"
#include "tests/benchmarks/commands.h"

namespace palpate::bench {

/// The options --contact and --friction, the same for every command.
struct FeatureOptions {
  // Empty: as the scene says; of an experiment that is no scene, surface and off.
  std::string contact = {};
  std::string friction = {};

  void AddTo(const CommandLine& command);
  /// None: as the scene says.
  std::optional<ContactModel> contact_model() const;
  /// Of an experiment that is no scene.
  Features features() const;
  /// What they say replaces what the scene says.  Where friction is asked of a scene that names no
  /// coefficient, its materials get those of the chapter's 2.5.6, 0.8 and 0.3.
  void ApplyTo(Scene& scene) const;
};

/// The names that the options and the JSON outputs use.
const char* NameOf(ContactModel contact);
const char* NameOf(FrictionModel friction);

}  // namespace palpate::bench
