#include <algorithm>

#include "client/doctor/checks.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/program/forked.h"
#include "devices/forcedimension/dhd_library.h"
#include "devices/haply/inverse_client.h"
#include "devices/openhaptics/device_nodes.h"
#include "devices/openhaptics/hd_library.h"

namespace palpate::doctor {
namespace {

constexpr const char* kSpacenavSocket = "/var/run/spnav.sock";
constexpr const char* kArm = "openhaptics";
constexpr const char* kDelta = "forcedimension";
constexpr const char* kInverse = "haply";
constexpr const char* kPuck = "spacemouse";

/// Returns the path of the page about a kind of arm, as the reader finds it.
std::string PageOf(const char* device) {
  return "(" + ShownPlaceOf(ProjectFile::kDevicePages) + "/" + device + "/README.md)";
}

std::string Listed(const HostFiles& host, const std::vector<std::string>& nodes) {
  std::string text;
  for (const std::string& node : nodes) text.append(" ").append(node.substr(host.root.size()));
  return text;
}

constexpr double kProbe_s = 30.0;

/// Returns what the probe found, or a fault with this remedy.  A vendor's library may crash.
Finding Probed(const char* device, const Probe& probe, const std::string& remedy) {
  const std::string who = std::string(device) + ": ";
  const ForkedEnd end = RunForked(
      [&](const auto& tell) {
        const ForeignCall call("its library");
        try {
          tell("+" + who + probe());
        } catch (const Error& error) {
          tell(std::string("-") + error.what());
        }
      },
      kProbe_s);
  if (!end.finished || end.lines.empty()) return Fault(who + end.how, remedy);
  const std::string said = end.lines[0].substr(1);
  return end.lines[0][0] == '+' ? Ok(said) : Fault(said, remedy);
}

Finding CheckArm(const HostFiles& host, const Probe& probe) {
  Finding finding =
      Probed(kArm, probe,
             "install OpenHaptics and the arm's driver, both from its vendor " + PageOf(kArm) +
                 ", or give the library's path in " + hd::kLibraryVariable);
  if (finding.status == Status::kFault) return finding;
  const DeviceNodes nodes = FindDeviceNodes(host.At("/dev"), [&](const std::string& path) {
    return host.MayOpen(path.substr(host.root.size()));
  });
  if (!nodes.closed.empty()) {
    return Fault(finding.found + "; this user has no access to" + Listed(host, nodes.closed),
                 "sudo usermod -aG dialout $USER (or the group that 'ls -l' shows there), and log "
                 "in again; or install the driver's udev rules");
  }
  if (nodes.open.empty()) {
    // Not a fault: an arm on the network has no device node.
    return Warning(finding.found + "; no arm is plugged in (no /dev/ttyACM*, fw* or parport*)",
                   "check its cable and power; an arm on the network needs neither");
  }
  return Ok(finding.found + "; accessible:" + Listed(host, nodes.open));
}

/// Returns the device nodes of the plugged-in USB devices of Force Dimension.
std::vector<std::string> DeltaNodes(const HostFiles& host) {
  std::vector<std::string> nodes;
  const std::string folder = "/sys/bus/usb/devices";
  for (const std::string& name : host.Names(folder, "")) {
    const auto file = [&](const char* what) {
      return host.Read(folder + "/" + name + "/" + what).value_or("");
    };
    const auto three = [](const std::string& digits) {
      return std::string(3 - std::min<std::size_t>(3, digits.size()), '0') + digits;
    };
    if (file("idVendor") != "1451") continue;
    nodes.push_back("/dev/bus/usb/" + three(file("busnum")) + "/" + three(file("devnum")));
  }
  return nodes;
}

Finding CheckDelta(const HostFiles& host, const Probe& probe) {
  Finding finding = Probed(kDelta, probe,
                           "install Force Dimension's SDK " + PageOf(kDelta) +
                               ", or give the library's path in " + dhd::kLibraryVariable);
  if (finding.status == Status::kFault) return finding;
  const std::vector<std::string> nodes = DeltaNodes(host);
  if (nodes.empty()) {
    return Warning(finding.found + "; no arm is plugged in (no USB device of vendor 1451)",
                   "check its USB cable and power");
  }
  for (const std::string& node : nodes) {
    const bool open = host.MayOpen(node);
    finding.found += (open ? "; accessible: " : "; this user has no access to ") + node;
    if (open) continue;
    finding =
        Fault(finding.found,
              "add a udev rule, SUBSYSTEM==\"usb\", ATTR{idVendor}==\"1451\", MODE=\"0666\" " +
                  PageOf(kDelta) + ", and plug the arm in again");
  }
  return finding;
}

Finding CheckInverse(const Probe& probe) {
  return Probed(
      kInverse, probe,
      "install the Inverse Service with the Haply Hub " + PageOf(kInverse) +
          " and start it: sudo systemctl start haply-inverse-service; or give its address in " +
          haply::kServiceVariable);
}

/// Returns whether a puck of 3Dconnexion (or of Logitech, which sold them before) is plugged in.
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
  const bool plugged = PuckIsPluggedIn(host);
  const std::string name = std::string(kPuck) + ": ", socket = kSpacenavSocket,
                    puck = plugged ? "; a puck is plugged in" : "; no puck is plugged in by USB";
  if (!host.Has(socket)) {
    return Fault(name + "spacenavd does not run (no " + socket + ")" + puck,
                 "sudo apt-get install spacenavd && sudo systemctl enable --now spacenavd");
  }
  if (!host.MayOpen(socket)) {
    return Fault(name + "this user may not open " + socket + puck,
                 "sudo chmod 666 " + socket +
                     ", or run the station as a user of the group that 'ls -l' shows there");
  }
  if (plugged) return Ok(name + "spacenavd listens" + puck);
  return Warning(name + "spacenavd listens" + puck, "plug it in (lsusb then names 3Dconnexion)");
}

}  // namespace

ArmProbes RealArmProbes() {
  return {.openhaptics = [] { return hd::LoadLibrary().file + " is loaded"; },
          .forcedimension = [] { return dhd::LoadLibrary().file + " is loaded"; },
          .haply =
              [] {
                const haply::Address address = haply::ServiceAddress();
                haply::CheckService(address);
                return "a service listens at ws://" + address.host + ":" + address.port;
              }};
}

Finding CheckDevice(const HostFiles& host, const std::string& device, const ArmProbes& probes) {
  if (device == kArm) return CheckArm(host, probes.openhaptics);
  if (device == kDelta) return CheckDelta(host, probes.forcedimension);
  if (device == kInverse) return CheckInverse(probes.haply);
  if (device == kPuck) return CheckPuck(host);
  if (!device.empty()) return Ok(device + ": needs nothing from the host");
  std::string ready = "none is named with --device; ready: simulated, mouse";
  const auto add = [&ready](const char* name, const Finding& finding) {
    if (finding.status != Status::kFault) ready += std::string(", ") + name;
  };
  add(kArm, CheckArm(host, probes.openhaptics));
  add(kDelta, CheckDelta(host, probes.forcedimension));
  add(kInverse, CheckInverse(probes.haply));
  add(kPuck, CheckPuck(host));
  return Ok(ready);
}

}  // namespace palpate::doctor
