#include "tests/benchmarks/features.h"

#include <algorithm>

namespace palpate::bench {
namespace {

void Override(const FeatureOptions& options, Features& features) {
  features.contact = options.contact_model().value_or(features.contact);
  for (const FrictionModel model :
       {FrictionModel::kOff, FrictionModel::kChapter, FrictionModel::kCoulomb}) {
    if (options.friction == NameOf(model)) features.friction = model;
  }
}

}  // namespace

const char* NameOf(ContactModel contact) {
  return contact == ContactModel::kSurface ? "surface" : "spheres";
}

const char* NameOf(FrictionModel friction) {
  switch (friction) {
    case FrictionModel::kChapter:
      return "chapter";
    case FrictionModel::kCoulomb:
      return "coulomb";
    case FrictionModel::kOff:
      break;
  }
  return "off";
}

void FeatureOptions::AddTo(const CommandLine& command) {
  const std::string scenes_own = contact.empty() ? "; default: that of the scene" : "";
  Add(command, "--contact", contact,
      "spheres (as in the chapter) or surface (the meshes)" + scenes_own)
      .OneOf({"spheres", "surface"});
  Add(command, "--friction", friction, "off, chapter (2.25-2.34) or coulomb" + scenes_own)
      .OneOf({"off", "chapter", "coulomb"});
}

std::optional<ContactModel> FeatureOptions::contact_model() const {
  for (const ContactModel model : {ContactModel::kSpheres, ContactModel::kSurface}) {
    if (contact == NameOf(model)) return model;
  }
  return std::nullopt;
}

Features FeatureOptions::features() const {
  Features features;
  Override(*this, features);
  return features;
}

void FeatureOptions::ApplyTo(Scene& scene) const {
  Override(*this, scene.features);
  const bool rough = std::any_of(scene.objects.begin(), scene.objects.end(), [](const Body& body) {
    return std::any_of(body.materials.begin(), body.materials.end(),
                       [](const Material& material) { return material.static_friction > 0.0; });
  });
  if (rough || scene.features.friction == FrictionModel::kOff) return;
  for (Body& body : scene.objects) {
    for (Material& material : body.materials) {
      material.static_friction = 0.8;
      material.dynamic_friction = 0.3;
    }
  }
}

}  // namespace palpate::bench
