#include "common/dds/security.h"

#include <chrono>
#include <ctime>
#include <filesystem>
#include <map>
#include <mutex>

#include <dds/dds.h>
#include <dds/ddsrt/log.h>
#include <dlfcn.h>
#include <spdlog/spdlog.h>

#include "common/dds/identity.h"
#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate::dds {
namespace {

namespace fs = std::filesystem;

/// Returns the folder of the plugins, which in Debian is beside the library that loads them and not
/// on the loader's path.
fs::path PluginFolder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&dds_create_domain), &info) == 0) return {};
  return fs::path(info.dli_fname).parent_path() / "libddsc0debian";
}

std::string Plugin(const char* name, const char* function) {
  const fs::path path = PluginFolder() / (std::string("libdds_security_") + name + ".so");
  if (!fs::exists(path)) {
    throw Error(path.string() +
                ": this plugin of Cyclone DDS is missing; install Debian's libddsc0debian, or omit "
                "--identity");
  }
  return "<Library path=\"" + path.string() + "\" initFunction=\"init_" + function +
         "\" finalizeFunction=\"finalize_" + function + "\"/>";
}

/// Returns an XML element that names a file of the identity.
std::string Named(const char* element, const fs::path& folder, const char* file) {
  const fs::path path = folder / file;
  const std::string whole = fs::absolute(path).string();
  // The name becomes part of an XML text, in which Cyclone DDS also expands ${VARIABLES}.
  if (whole.find_first_of("<&$\\") != std::string::npos) {
    throw Error("--identity: " + Quoted(whole) +
                ": DDS accepts no path with < & $ or \\; move the identity to another folder");
  }
  return std::string("<") + element + ">file:" + whole + "</" + element + ">";
}

/// Called in DDS's threads.
void Log(void*, const dds_log_data_t* data) {
  std::string text(data->message, data->size);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  using Clock = std::chrono::steady_clock;
  static std::mutex mutex;
  static std::map<std::string, Clock::time_point> said;
  {
    const std::lock_guard lock(mutex);
    if (said.size() > 256) said.clear();
    const auto [line, is_new] = said.try_emplace(text, Clock::now());
    if (!is_new && Clock::now() - line->second < std::chrono::seconds(1)) return;
    line->second = Clock::now();
  }
  if ((data->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0) {
    spdlog::error("DDS: {}", text);
  } else {
    spdlog::warn("DDS: {}", text);
  }
}

}  // namespace

std::string SecurityConfig(const std::string& identity) {
  const fs::path folder(identity);
  CheckIdentity(identity, std::time(nullptr));
  return "<Security><Authentication>" + Plugin("auth", "authentication") +
         Named("IdentityCA", folder, "identity_ca.pem") +
         Named("IdentityCertificate", folder, "cert.pem") + Named("PrivateKey", folder, "key.pem") +
         "</Authentication><AccessControl>" + Plugin("ac", "access_control") +
         Named("PermissionsCA", folder, "permissions_ca.pem") +
         Named("Governance", folder, "governance.p7s") +
         Named("Permissions", folder, "permissions.p7s") + "</AccessControl><Cryptographic>" +
         Plugin("crypto", "crypto") + "</Cryptographic></Security>";
}

void LogWhatDdsSays() {
  dds_set_log_sink(&Log, nullptr);
  dds_set_trace_sink([](void*, const dds_log_data_t*) {}, nullptr);  // drops the same messages,
                                                                     // sent to this sink again
}

}  // namespace palpate::dds
