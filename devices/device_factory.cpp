#include "devices/device_factory.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "common/error.h"
#include "common/text/joined.h"

namespace palpate {
namespace {

DeviceKind Find(const std::string& name) {
  for (DeviceKind& kind : AllDeviceKinds()) {
    if (kind.is_file ? IsDriverFile(name) : kind.name == name) return std::move(kind);
  }
  throw UsageError("--device " + name + ": is not a device; give one of " + DeviceNames());
}

DeviceKind Check(const std::string& name, const std::string& model, double rate_Hz) {
  DeviceKind kind = Find(name);
  if (!model.empty() &&
      std::find(kind.models.begin(), kind.models.end(), model) == kind.models.end()) {
    throw UsageError("--model " + model + ": " +
                     (kind.models.empty() ? "--device " + name + " has no models; leave it out"
                                          : "is not a model of --device " + name +
                                                "; give one of " + Joined(kind.models)));
  }
  if (!(rate_Hz >= 1000.0 && rate_Hz <= kind.max_rate_Hz)) {
    std::ostringstream message;
    message << "--rate " << rate_Hz << ": --device " << name << " runs at 1000";
    if (kind.max_rate_Hz > 1000.0) message << " to " << kind.max_rate_Hz;
    throw UsageError(message.str() + " Hz");
  }
  return kind;
}

PoseScript Seen(const PoseScript& script, const Workspace& workspace) {
  std::vector<PoseScript::Key> keys = script.keys();
  // Minimum-jerk segments between the mapped keys are the mapped segments: the map is a similarity.
  for (PoseScript::Key& key : keys) key.X_WH = workspace.ToDevice(key.X_WH);
  return PoseScript(std::move(keys));
}

}  // namespace

std::string DeviceNames() {
  return Joined(AllDeviceKinds(), &DeviceKind::name);
}

std::string DeviceHelp() {
  std::ostringstream help;
  for (const DeviceKind& kind : AllDeviceKinds()) {
    help << "  " << kind.name << std::string(16 - std::min<std::size_t>(15, kind.name.size()), ' ')
         << kind.what << "\n";
    if (!kind.models.empty()) help << "                  --model " << Joined(kind.models) << "\n";
  }
  return help.str();
}

bool IsDriverFile(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".so");
}

bool DeviceNeedsScript(const std::string& name) {
  return Find(name).needs_script;
}

void CheckDevice(const std::string& name, const std::string& model, double rate_Hz) {
  Check(name, model, rate_Hz);
}

void CheckDriver(const std::string& name) {
  if (const DeviceKind kind = Find(name); kind.check_host != nullptr) kind.check_host(name);
}

std::unique_ptr<Device> MakeDevice(const DeviceOptions& options) {
  const DeviceKind kind = Check(options.name, options.model, options.rate_Hz);
  if (kind.needs_script && !options.script) {
    throw Error("--device " + options.name + " needs a script of poses; give one with --script");
  }
  DeviceOptions own = options;
  if (own.model.empty() && !kind.models.empty()) own.model = kind.models.front();
  if (!options.workspace) return kind.make(own);
  own.start = options.workspace->ToDevice(options.start);
  if (options.script) own.script = Seen(*options.script, *options.workspace);
  return std::make_unique<WorkspaceDevice>(kind.make(own), *options.workspace);
}

}  // namespace palpate
