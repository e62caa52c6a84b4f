#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "scenes/scene.h"

namespace palpate::bench {

/// The options --contact and --friction, the same for every command.
struct FeatureOptions {
  std::string contact = "spheres";
  std::string friction = "off";

  void AddTo(CLI::App& command);
  /// Throws UsageError where this version has not what they ask for.
  Features features() const;
};

}  // namespace palpate::bench
