#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace palpate {

/// Returns the hash in lower-case hexadecimal digits.
std::string Sha256(std::string_view text);
struct HashedFile {
  std::string sha256;
  std::int64_t bytes = 0;
};
/// Throws Error if the file cannot be read.
/// @param folder  that no link may lead out of (OpenFileBelow); empty: any may.
HashedFile Sha256OfFile(const std::string& file, const std::string& folder = "");

/// The hash of a file that is still written: what was read once is not read again, so that nobody
/// can change it afterwards without being noticed.
class GrowingHash {
 public:
  /// As Sha256OfFile.
  explicit GrowingHash(const std::string& file, const std::string& folder = "");
  ~GrowingHash();
  GrowingHash(const GrowingHash&) = delete;
  GrowingHash& operator=(const GrowingHash&) = delete;

  /// Reads on, to the file's present end or until `most` bytes of it are read.  Throws Error.
  void ReadOn(std::int64_t most = kWhole);
  HashedFile so_far() const;

 private:
  static constexpr std::int64_t kWhole = ~(std::int64_t{1} << 63);
  const std::string file_;
  int fd_ = -1;
  std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> sum_;
  std::int64_t bytes_ = 0;
};

}  // namespace palpate
