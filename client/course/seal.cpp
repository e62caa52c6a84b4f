#include "client/course/seal.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <unistd.h>

#include "common/error.h"
#include "common/files/output.h"
#include "common/files/private_file.h"
#include "common/files/whole_file.h"
#include "common/revision.h"

namespace palpate {

using Json = nlohmann::json;
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Seal, format, software, recording, sha256, bytes, person, name,
                                   station, scene, scene_hash, exam, exam_number, exam_sha256, task,
                                   exercise, n, exercise_sha256, criteria_sha256, expert_sha256,
                                   begun_s, ended_s, sealed_s, whole, reason, previous)
// An exam that an earlier version opened has no hash of the expert.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ExamTask, exercise, time_s, trials, exercise_sha256,
                                                criteria_sha256, expert_sha256)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Roll::Entry, person, name, task, exercise, n, station, scene,
                                   scene_hash, begun_s, waited_s, recording, sha256, seal, lost,
                                   counts)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Roll, format, software, exam, exam_number, exam_sha256, tasks,
                                   opened_s, ends_s, closed_s, complete, last, trials)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Mark, format, software, exam_number, person, exercise, n, bytes,
                                   sha256, made_s)

namespace {

constexpr std::size_t kLargestKey = 16 * 1024;
constexpr std::size_t kSignatureBytes = 64;

using Key = std::shared_ptr<evp_pkey_st>;
using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Digest = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

std::string Software() {
  return fmt::format("palpate {}, physics {}", PALPATE_VERSION, kPhysicsRevision);
}

std::string Hex(const unsigned char* bytes, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

/// Decodes lower-case hexadecimal digits; empty for any other text.
std::string FromHex(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    const std::size_t high = kDigits.find(text[i]), low = kDigits.find(text[i + 1]);
    if (high == kDigits.npos || low == kDigits.npos) return "";
    bytes += static_cast<char>(16 * high + low);
  }
  return 2 * bytes.size() == text.size() ? bytes : "";
}

const unsigned char* Bytes(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

/// Returns as text what `write` writes into a memory BIO.
template <class Write>
std::string PemOf(Write write) {
  const Bio bio(BIO_new(BIO_s_mem()), BIO_free);
  if (write(bio.get()) != 1)
    throw Error(
        "OpenSSL cannot make an Ed25519 key; use a build of OpenSSL without FIPS restrictions");
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

/// Creates a key file, complete and readable by its owner only before it gets its name; an existing
/// one is kept.
void WriteNewKey(const std::string& file) {
  const Key key(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"), EVP_PKEY_free);
  const std::string pem = PemOf([&](BIO* bio) {
    return key ? PEM_write_bio_PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr, nullptr)
               : 0;
  });
  const std::string made = fmt::format("{}.{}.new", file, getpid());
  const int out = open(made.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  bool good = out >= 0 && write(out, pem.data(), pem.size()) == static_cast<ssize_t>(pem.size()) &&
              fsync(out) == 0;
  if (out >= 0) close(out);
  good = good && (link(made.c_str(), file.c_str()) == 0 || errno == EEXIST);
  const int error = errno;
  unlink(made.c_str());
  if (good) return;
  throw Error(
      fmt::format("{}: cannot create the key ({}); make the course's folder writable, or free "
                  "space on its disk",
                  file, std::strerror(error)));
}

template <class Sealed>
std::string TextOf(Sealed sealed, const SealKey& key) {
  sealed.software = Software();
  const Json json = sealed;
  return Json({{"key", key.name()}, {"sealed", json}, {"signature", key.Sign(json.dump())}})
             .dump() +
         "\n";
}

template <class Sealed>
Sealed Open(std::string_view text, const SealKey& key, const std::string& file) {
  const auto refuse = [&](const std::string& why) { throw Error(file + ": " + why); };
  Json json;
  Sealed sealed;
  std::string signed_by, signature, body;
  try {
    json = Json::parse(text);
    signed_by = json.at("key");
    signature = json.at("signature");
    if (json.at("sealed").at("format") != Sealed::kFormat) {
      refuse("is of format " + json.at("sealed").at("format").dump() + ", and this program knows " +
             Sealed::kFormat +
             ": verify it with the Palpate that made it, where it has not been changed");
    }
    sealed = json.at("sealed");
    const Json again = sealed;
    body = again.dump();
    // The whole text must match: any other byte or order counts as a change.
    const Json all = {{"key", signed_by}, {"sealed", again}, {"signature", signature}};
    if (all.dump() + "\n" != text) refuse("the seal has been changed since it was made");
  } catch (const Json::exception&) {
    refuse("is no seal, or has been changed since it was made");
  }
  if (signed_by != key.name()) {
    refuse(
        fmt::format("is sealed by the key {}..., and not by {}...: another course's, or it has "
                    "been changed",
                    std::string_view(signed_by).substr(0, 16), key.name().substr(0, 16)));
  }
  if (!key.Signed(body, signature)) refuse("the seal has been changed: its signature is not of it");
  return sealed;
}

}  // namespace

SealKey::SealKey(Key key) : key_(std::move(key)) {
  std::array<unsigned char, 32> bytes{};
  std::size_t size = bytes.size();
  if (!key_ || EVP_PKEY_get_id(key_.get()) != EVP_PKEY_ED25519 ||
      EVP_PKEY_get_raw_public_key(key_.get(), bytes.data(), &size) != 1) {
    key_.reset();
    return;
  }
  name_ = Sha256({reinterpret_cast<const char*>(bytes.data()), size});
}

SealKey SealKey::OfCourse(const std::string& folder) {
  const std::string file = folder + "/" + kFile;
  if (!std::filesystem::exists(file)) WriteNewKey(file);
  const std::string pem =
      ReadFileBelow(folder, file, kLargestKey, IsPrivate("the exams' key", file));
  const Bio bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free);
  // An encrypted key must not make the library ask a terminal for its password.
  char none[] = "";
  SealKey key(Key(PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, none), EVP_PKEY_free));
  if (!key.key_) {
    throw Error(file +
                ": is not an Ed25519 key (PEM); restore it from a copy, or move it away to get a "
                "new key, which does not verify earlier seals");
  }
  const std::string written =
      PemOf([&](BIO* out) { return PEM_write_bio_PUBKEY(out, key.key_.get()); });
  const std::string beside = folder + "/" + kPublicFile;
  if (std::filesystem::is_symlink(beside) || TryReadWholeFile(beside, kLargestKey) != written) {
    WriteOutput("public key", beside, written, Links::kReplace);
  }
  return key;
}

SealKey SealKey::ReadPublic(const std::string& file) {
  const std::string pem = ReadWholeFile(file, kLargestKey, "--key");
  const Bio bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free);
  SealKey key(Key(PEM_read_bio_PUBKEY(bio.get(), nullptr, nullptr, nullptr), EVP_PKEY_free));
  if (!key.key_) {
    throw Error("--key " + file + ": is not the public key of a course; give its " + kPublicFile);
  }
  return key;
}

std::string SealKey::Sign(std::string_view text) const {
  const Digest digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  std::array<unsigned char, kSignatureBytes> signature{};
  std::size_t size = signature.size();
  if (EVP_DigestSignInit(digest.get(), nullptr, nullptr, nullptr, key_.get()) != 1 ||
      EVP_DigestSign(digest.get(), signature.data(), &size, Bytes(text), text.size()) != 1) {
    throw Error(
        "OpenSSL cannot sign with the course's key; use a build of OpenSSL without FIPS "
        "restrictions");
  }
  return Hex(signature.data(), size);
}

bool SealKey::Signed(std::string_view text, const std::string& signature) const {
  const std::string bytes = FromHex(signature);
  const Digest digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  return bytes.size() == kSignatureBytes &&
         EVP_DigestVerifyInit(digest.get(), nullptr, nullptr, nullptr, key_.get()) == 1 &&
         EVP_DigestVerify(digest.get(), Bytes(bytes), bytes.size(), Bytes(text), text.size()) == 1;
}

std::string TasksText(const std::vector<ExamTask>& tasks) {
  return Json(tasks).dump();
}

std::vector<ExamTask> ReadTasks(const std::string& json) {
  return Json::parse(json).get<std::vector<ExamTask>>();
}

std::string SealText(const Seal& seal, const SealKey& key) {
  return TextOf(seal, key);
}
std::string SealText(const Roll& roll, const SealKey& key) {
  return TextOf(roll, key);
}
std::string SealText(const Mark& mark, const SealKey& key) {
  return TextOf(mark, key);
}

Seal OpenSeal(std::string_view text, const SealKey& key, const std::string& file) {
  return Open<Seal>(text, key, file);
}
Roll OpenRoll(std::string_view text, const SealKey& key, const std::string& file) {
  return Open<Roll>(text, key, file);
}
Mark OpenMark(std::string_view text, const SealKey& key, const std::string& file) {
  return Open<Mark>(text, key, file);
}

}  // namespace palpate
