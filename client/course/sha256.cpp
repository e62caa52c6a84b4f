#include "client/course/sha256.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include "common/error.h"
#include "common/files/whole_file.h"

namespace palpate {
namespace {

using Digest = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;
using Hash = std::array<unsigned char, 32>;

std::string Hex(const Hash& hash) {
  std::string text;
  for (const unsigned char byte : hash) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace

std::string Sha256(std::string_view text) {
  Hash hash{};
  EVP_Digest(text.data(), text.size(), hash.data(), nullptr, EVP_sha256(), nullptr);
  return Hex(hash);
}

HashedFile Sha256OfFile(const std::string& file, const std::string& folder) {
  GrowingHash hash(file, folder);
  hash.ReadOn();
  return hash.so_far();
}

GrowingHash::GrowingHash(const std::string& file, const std::string& folder)
    : file_(file), sum_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
  constexpr std::uint64_t kAny = ~std::uint64_t{0} >> 1;
  EVP_DigestInit_ex(sum_.get(), EVP_sha256(), nullptr);
  fd_ = folder.empty() ? OpenRegularFile(file, kAny) : OpenFileBelow(folder, file, kAny);
}

GrowingHash::~GrowingHash() {
  close(fd_);
}

void GrowingHash::ReadOn(std::int64_t most) {
  std::vector<char> buffer(std::size_t{1} << 20);
  while (bytes_ < most) {
    const auto want =
        std::min<std::int64_t>(most - bytes_, static_cast<std::int64_t>(buffer.size()));
    const ssize_t got = read(fd_, buffer.data(), static_cast<std::size_t>(want));
    if (got == 0) return;
    if (got < 0) throw Error(file_ + ": cannot be read (" + std::strerror(errno) + ")");
    EVP_DigestUpdate(sum_.get(), buffer.data(), static_cast<std::size_t>(got));
    bytes_ += got;
  }
}

HashedFile GrowingHash::so_far() const {
  const Digest copy(EVP_MD_CTX_new(), EVP_MD_CTX_free);  // it goes on being added to
  Hash hash{};
  EVP_MD_CTX_copy_ex(copy.get(), sum_.get());
  EVP_DigestFinal_ex(copy.get(), hash.data(), nullptr);
  return {Hex(hash), bytes_};
}

}  // namespace palpate
