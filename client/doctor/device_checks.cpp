#include "client/doctor/device_checks.h"

#include <vector>

#include <sys/stat.h>

#include "common/error.h"
#include "devices/openhaptics/device_nodes.h"
#include "devices/openhaptics/hd_library.h"

namespace palpate::doctor {
namespace {

constexpr const char* kSpacenavSocket = "/var/run/spnav.sock";
constexpr const char* kArm = "openhaptics";
constexpr const char* kPuck = "spacemouse";

std::string Listed(const HostFiles& host, const std::vector<std::string>& nodes) {
  std::string text;
  for (const std::string& node : nodes) text.append(" ").append(node.substr(host.root.size()));
  return text;
}

Finding CheckArm(const HostFiles& host, const LoadArmLibrary& load) {
  Finding finding{.check = "device"};
  try {
    finding.found = std::string(kArm) + ": " + load() + " is loaded";
  } catch (const Error& error) {
    finding.status = Status::kFault;
    finding.found = error.what();
    finding.remedy =
        "install OpenHaptics and the arm's driver, both of its vendor's "
        "(devices/openhaptics/README.md), or name the library in " +
        std::string(hd::kLibraryVariable);
    return finding;
  }
  const DeviceNodes nodes = FindDeviceNodes(host.At("/dev"), [&](const std::string& path) {
    return host.MayOpen(path.substr(host.root.size()));
  });
  if (!nodes.closed.empty()) {
    finding.status = Status::kFault;
    finding.found += "; this user may not open" + Listed(host, nodes.closed);
    finding.remedy =
        "sudo usermod -aG dialout $USER (or the group that 'ls -l' shows there), and log in again; "
        "or "
        "install the driver's udev rules";
  } else if (nodes.open.empty()) {
    // No fault: an arm on the network has no node.
    finding.status = Status::kWarning;
    finding.found += "; no arm is plugged in (no /dev/ttyACM*, fw* or parport*)";
    finding.remedy = "check its cable and power; an arm on the network needs neither";
  } else {
    finding.found += "; may be opened:" + Listed(host, nodes.open);
  }
  return finding;
}

/// True where a puck of 3Dconnexion's (or of Logitech's, as they were sold before) is plugged in.
bool PuckIsPluggedIn(const HostFiles& host) {
  for (const std::string& node : host.Names("/sys/class/hidraw", "hidraw")) {
    const std::string text = host.Read("/sys/class/hidraw/" + node + "/device/uevent").value_or("");
    if (text.find(":0000256F:") != std::string::npos ||
        text.find(":0000046D:0000C6") != std::string::npos) {
      return true;
    }
  }
  return false;
}

Finding CheckPuck(const HostFiles& host) {
  Finding finding{.check = "device"};
  const bool plugged = PuckIsPluggedIn(host);
  const std::string puck = plugged ? "a puck is plugged in" : "no puck is plugged in by USB";
  struct stat status {};
  if (stat(host.At(kSpacenavSocket).c_str(), &status) != 0) {
    finding.status = Status::kFault;
    finding.found =
        std::string(kPuck) + ": spacenavd does not run (no " + kSpacenavSocket + "); " + puck;
    finding.remedy = "sudo apt-get install spacenavd && sudo systemctl enable --now spacenavd";
  } else if (!host.MayOpen(kSpacenavSocket)) {
    finding.status = Status::kFault;
    finding.found =
        std::string(kPuck) + ": this user may not open " + kSpacenavSocket + "; " + puck;
    finding.remedy = std::string("sudo chmod 666 ") + kSpacenavSocket +
                     ", or run the station as a user of the group that 'ls -l' shows there";
  } else {
    finding.found = std::string(kPuck) + ": spacenavd listens; " + puck;
    if (!plugged) {
      finding.status = Status::kWarning;
      finding.remedy = "plug it in (lsusb then names 3Dconnexion)";
    }
  }
  return finding;
}

}  // namespace

std::string LoadOpenHaptics() {
  return hd::LoadLibrary(hd::LibraryCandidates()).file;
}

Finding CheckDevice(const HostFiles& host, const std::string& device, const LoadArmLibrary& load) {
  if (device == kArm) return CheckArm(host, load);
  if (device == kPuck) return CheckPuck(host);
  if (!device.empty()) return {.check = "device", .found = device + ": needs nothing of the host"};
  const bool arm = CheckArm(host, load).status != Status::kFault;
  const bool puck = CheckPuck(host).status != Status::kFault;
  return {.check = "device",
          .found = std::string("none is named with --device; ready would be: simulated, mouse") +
                   (arm ? ", openhaptics" : "") + (puck ? ", spacemouse" : "")};
}

}  // namespace palpate::doctor
