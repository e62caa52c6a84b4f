#include "tests/benchmarks/features.h"

#include <algorithm>

namespace palpate::bench {
namespace {

constexpr double kStaticFriction = 0.8, kDynamicFriction = 0.3;

void GiveFriction(Scene& scene) {
  const auto rough = [](const Body& body) {
    return std::any_of(body.materials.begin(), body.materials.end(),
                       [](const Material& material) { return material.static_friction > 0.0; });
  };
  if (std::any_of(scene.objects.begin(), scene.objects.end(), rough)) return;
  for (Body& body : scene.objects) {
    for (Material& material : body.materials) {
      material.static_friction = kStaticFriction;
      material.dynamic_friction = kDynamicFriction;
    }
  }
}

void Choose(const std::string& contact, const std::string& friction, Features& features) {
  for (const ContactModel model : {ContactModel::kSpheres, ContactModel::kSurface}) {
    if (contact == NameOf(model)) features.contact = model;
  }
  for (const FrictionModel model :
       {FrictionModel::kOff, FrictionModel::kChapter, FrictionModel::kCoulomb}) {
    if (friction == NameOf(model)) features.friction = model;
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

void FeatureOptions::AddTo(CLI::App& command) {
  const auto unless_given = [](const std::string& value) {
    return value.empty() ? " (default: as the scene says)" : "";
  };
  command
      .add_option(
          "--contact", contact,
          std::string("spheres (the chapter's) or surface (the meshes)") + unless_given(contact))
      ->check(CLI::IsMember({"spheres", "surface"}))
      ->capture_default_str();
  command
      .add_option("--friction", friction,
                  std::string("off, chapter (2.25-2.34) or coulomb") + unless_given(friction))
      ->check(CLI::IsMember({"off", "chapter", "coulomb"}))
      ->capture_default_str();
}

void FeatureOptions::ApplyTo(Scene& scene) const {
  Choose(contact, friction, scene.features);
  if (!friction.empty() && scene.features.friction != FrictionModel::kOff) GiveFriction(scene);
}

Features FeatureOptions::features() const {
  Features features{.contact = ContactModel::kSpheres};
  Choose(contact, friction, features);
  return features;
}

}  // namespace palpate::bench
